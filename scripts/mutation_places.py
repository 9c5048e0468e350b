"""The places of a C++ source at which scripts/mutants changes one thing, and the change.

It reads tokens and braces, no types: the compiler refuses the changes that make no sense. It relies on clang-format, which puts a space on
both sides of a binary operator and none inside a template's brackets. These are left alone: comments, texts, lines of the preprocessor,
static_assert, concepts, template parameters and arguments, enumerators, labels, default arguments, pure virtual functions, defaulted ones,
declared operators, shifts, and lines with NOLINT.
"""
import bisect
import collections
import re

Place = collections.namedtuple('Place', 'kind start end after')  # text[start:end] becomes `after`
Token = collections.namedtuple('Token', 'kind text start end')

TOKENS = re.compile(
    r'(?P<none>//[^\n]*|/\*.*?\*/|\s+|^[ \t]*#(?:[^\n]*\\\n)*[^\n]*)'
    r'|(?P<text>(?:u8|[uUL])?R"(?P<mark>\w*)\(.*?\)(?P=mark)"|(?:u8|[uUL])?"(?:\\.|[^"\\\n])*"|\'(?:\\.|[^\'\\\n])+\')'
    r'|(?P<number>0[xX][\da-fA-F\']+\w*|(?:\d[\d\']*\.?\d*|\.\d+)(?:[eE][+-]?\d+)?\w*)'
    r'|(?P<word>[A-Za-z_]\w*)'
    r'|(?P<sign><=>|<<=|>>=|->\*?|\+\+|--|<<|<=|>=|==|!=|&&|\|\||[-+*/%&|^]=|::|\.\.\.|.)', re.S | re.M)

OTHERS = {
    '<': ('<=', '>='), '<=': ('<', '>'), '>': ('>=', '<='), '>=': ('>', '<'), '==': ('!=',), '!=': ('==',),
    '+': ('-',), '-': ('+',), '*': ('/',), '/': ('*',), '&&': ('||',), '||': ('&&',), '+=': ('-=',), '-=': ('+=',),
    'min': ('max',), 'max': ('min',), 'cwiseMin': ('cwiseMax',), 'cwiseMax': ('cwiseMin',), 'minCoeff': ('maxCoeff',),
    'maxCoeff': ('minCoeff',), 'true': ('false',), 'false': ('true',)}
KINDS = {**dict.fromkeys(('<', '<=', '>', '>=', '==', '!='), 'relation'), **dict.fromkeys('+-*/', 'arithmetic'),
         **dict.fromkeys(('&&', '||'), 'and, or'), **dict.fromkeys(('+=', '-='), 'sum'), **dict.fromkeys(('true', 'false'), 'truth')}
CONDITIONS = {'if', 'for', 'while', 'switch', 'constexpr', 'catch'}
STATEMENTS = CONDITIONS | {'return', 'else', 'do', 'try', 'case', 'default', 'throw', 'delete', 'new', 'using', 'goto', 'break', 'continue',
                           'static_assert', 'co_return', 'co_await', 'sizeof', 'assert'}
LABELS = ('case', 'default', 'public', 'protected', 'private')


class Source:
    def __init__(self, text):
        self.text = text
        self.tokens = [Token(found.lastgroup if found.lastgroup != 'mark' else 'text', found[0], *found.span())
                       for found in TOKENS.finditer(text) if found.lastgroup != 'none']
        self.line_starts = [0] + [place.end() for place in re.finditer('\n', text)]
        self.partner = {}      # of each bracket, by index
        self.left_alone = set()
        self.room = {}         # what each token lies in: namespace, class, enum, function, block, value
        self.begins = set()    # tokens that begin a statement of a function
        self.statement = {}    # the first token of what each token belongs to
        self.pair_brackets()
        self.find_templates()
        self.find_rooms()
        self.find_left_alone()

    def at(self, index):
        return self.tokens[index].text if 0 <= index < len(self.tokens) else ''

    def line(self, offset):
        return bisect.bisect_right(self.line_starts, offset)

    def spaced(self, index):
        token = self.tokens[index]
        return self.text[token.start - 1:token.start].isspace() and self.text[token.end:token.end + 1].isspace()

    def pair_brackets(self):
        opened = []
        for index, token in enumerate(self.tokens):
            if token.kind == 'text':
                continue
            if token.text in '([{':
                opened.append(index)
            elif token.text in ')]}' and opened:
                self.partner[index] = opened.pop()
                self.partner[self.partner[index]] = index

    def find_templates(self):
        """Marks `<...>` of templates."""
        for index, token in enumerate(self.tokens):
            joined = index > 0 and self.tokens[index - 1].kind == 'word' and self.tokens[index - 1].end == token.start
            if token.text != '<' or index in self.left_alone or not (joined or self.at(index - 1) == 'template'):
                continue
            depth, place = 1, index + 1
            while depth > 0 and place < len(self.tokens) and self.at(place) not in (';', '{'):
                depth += {'<': not self.spaced(place), '>': -1}.get(self.at(place), 0)
                place = self.partner.get(place, place) + 1 if self.at(place) == '(' else place + 1
            if depth == 0:
                self.left_alone.update(range(index, place))

    def kind_of_brace(self, index, head, around):
        """What `{` opens. `head`: the tokens since the statement began."""
        words = [self.at(place) for place in head if place not in self.left_alone]
        before = self.at(index - 1)
        if around in ('function', 'block') and before in ('else', 'do', 'try', ';', '{', '}', ':', ''):
            return 'block'
        if before == ')' and self.at(self.partner.get(index - 1, 0) - 1) in CONDITIONS:
            return 'block'
        returns = '->' in words and '(' in words and '=' not in words
        if returns or before in (')', ']', 'const', 'noexcept', 'override', 'final', 'mutable', 'try'):
            return 'function'
        if around in ('function', 'block'):
            return 'value' if not {'struct', 'class', 'enum'} & set(words) else 'class'
        if 'namespace' in words or 'extern' in words:
            return 'namespace'
        if 'enum' in words:
            return 'enum'
        if {'class', 'struct', 'union'} & set(words) and '=' not in words and '(' not in words:
            return 'class'
        return 'function' if before == '}' and ':' in words else 'value'

    def find_rooms(self):
        opened = []  # (kind, the first token of the statement around)
        first, around, brackets = 0, 'namespace', 0
        for index, token in enumerate(self.tokens):
            self.room[index] = around
            self.statement[index] = first
            if first == index and around in ('function', 'block'):
                self.begins.add(index)
            text = token.text if token.kind != 'text' else ''
            if text == '{':
                kind = self.kind_of_brace(index, range(first, index), around)
                opened.append((around, first, brackets))
                around = kind if kind != 'value' else around
                if kind != 'value':
                    first, brackets = index + 1, 0
                else:
                    opened[-1] = (around, None, brackets)
                    brackets += 1
            elif text == '}' and opened:
                around, before, inner = opened.pop()
                if before is None:  # a value in the middle of a statement
                    brackets = inner
                else:
                    # A lambda in the middle of a statement does not end it.
                    brackets = inner
                    first = before if inner > 0 or self.at(index + 1) in (';', ')', ',', '(', '.') else index + 1
                self.room[index] = around
            elif text and text in '([':
                brackets += 1
            elif text and text in ')]':
                brackets -= 1
                opener = self.partner.get(index, 0)
                if text == ')' and brackets == 0 and self.at(opener - 1) in CONDITIONS:
                    first = index + 1
            elif brackets == 0 and (text in (';', 'else', 'do') or text == ':' and self.at(first) in LABELS):
                first = index + 1

    def find_left_alone(self):
        quiet = set()
        for number, line in enumerate(self.text.split('\n'), 1):
            if 'NOLINT' in line:
                quiet |= {number, number + 1} if 'NOLINTNEXTLINE' in line else {number}
            if re.search(r'\b(?:requires|concept)\b', line):
                quiet.add(number)
        for index, token in enumerate(self.tokens):
            head = self.at(self.statement[index])
            declared = self.room[index] in ('namespace', 'class')
            if (self.line(token.start) in quiet or self.room[index] == 'enum' or head in ('static_assert', 'case', 'using', 'template')
                    and (head != 'template' or self.at(index - 1) == 'operator') or self.at(index - 1) == 'operator'):
                self.left_alone.add(index)
            if declared and self.at(index - 1) == '=':
                bracket = next((place for place in range(index - 2, self.statement[index] - 1, -1)
                                if self.at(place) == '(' and self.partner.get(place, 0) > index), None)
                if bracket is not None or self.at(index - 2) in (')', 'const', 'noexcept', 'override'):
                    self.left_alone.add(index)  # a default argument, or a function without a body

    def has_text(self, index):
        """Whether the statement joins texts."""
        first = self.statement[index]
        last = next((place for place in range(index, len(self.tokens)) if self.at(place) == ';'), index)
        return any(token.kind == 'text' or token.text in ('string', 'to_string') for token in self.tokens[first:last])

    def end_of_call(self, index):
        """The `;` of a statement that is only a call; None if it is another one."""
        called = False
        while index < len(self.tokens):
            token = self.tokens[index]
            if token.text == '(':
                index, called = self.partner.get(index, len(self.tokens)) + 1, True
                if self.at(index) == ';':
                    return index
            elif token.text == '[':
                index = self.partner.get(index, len(self.tokens)) + 1
            elif token.kind == 'word' and token.text not in STATEMENTS and self.tokens[index + 1].kind != 'word':
                index += 1
            elif token.text in ('::', '.', '->') or index in self.left_alone and not called:
                index += 1
            else:
                return None
        return None

    def deleted(self, kind, index, end):
        start, stop = self.tokens[index].start, self.tokens[end].start
        return Place(kind, start, stop, '\n' * self.text.count('\n', start, stop))

    def places(self):
        for index, token in enumerate(self.tokens):
            if index in self.left_alone or token.kind == 'text':
                continue
            if token.kind == 'number':
                other = other_number(token.text)
                if other and self.at(index - 2) != 'operator':
                    yield Place('constant', token.start, token.end, other)
            elif token.text == '!':
                yield Place('not', token.start, token.end, '')
            elif token.text in ('min', 'max'):
                if self.at(index - 1) == '::' and self.at(index - 2) == 'std' and self.at(index + 1) == '(':
                    yield Place('min, max', token.start, token.end, OTHERS[token.text][0])
            elif token.text in OTHERS and token.kind == 'word':
                yield Place(KINDS.get(token.text, 'min, max'), token.start, token.end, OTHERS[token.text][0])
            elif token.text in OTHERS and self.spaced(index) and not (token.text in ('+', '+=') and self.has_text(index)):
                for other in OTHERS[token.text]:
                    yield Place(KINDS[token.text], token.start, token.end, other)
            if index in self.begins and token.kind == 'word':
                guarded = self.room[index] == 'block' or self.at(index - 1) in (')', 'else')
                if token.text == 'return' and guarded:
                    end = next((place for place in range(index, len(self.tokens))
                                if self.at(place) == ';' and self.statement[place] == index), None)
                    if end is not None:
                        yield self.deleted('return', index, end)
                elif token.text != 'return':
                    end = self.end_of_call(index)
                    if end is not None:
                        yield self.deleted('call', index, end)


def other_number(text):
    """0 becomes 1, and x becomes 2x, written in the same way."""
    parts = re.fullmatch(r'(0[xX])([\da-fA-F]+)([uUlLzZ]*)|([\d.]+)([eE][+-]?\d+)?([uUlLzZfF]*)', text.replace("'", ''))
    if parts is None:
        return None
    if parts[1]:
        return f'{parts[1]}{2 * int(parts[2], 16) or 1:x}{parts[3]}'
    number, exponent, suffix = parts[4], parts[5] or '', parts[6]
    if '.' in number:
        digits = len(number.split('.')[1])
        return f'{2 * float(number) or 1.0:.{max(digits, 1)}f}{exponent}{suffix}'
    return f'{2 * int(number) or 1}{exponent}{suffix}'


def places(text):
    return list(Source(text).places())

"""The outline of a C++ file: its classes, and its functions with the namespace or class of each.

It reads the code of this repository, not all of C++: it expands no macro, and reads all branches of an #if.
"""

import dataclasses
import re

TOKEN = re.compile(r"""
    (?P<left_out> //[^\n]* | /\*.*?\*/ | ^[ \t]*\#(?:[^\n\\]|\\.)* | \[\[.*?\]\] )  # comments, directives, attributes
  | R"(?P<mark>\w*)\(.*?\)(?P=mark)" | "(?:[^"\\\n]|\\.)*" | '(?:[^'\\\n]|\\.)+'
  | :: | -> | [A-Za-z_]\w* | \.?\d(?:'?[\w.])* | \S
""", re.X | re.S | re.M)
NAME = re.compile(r"[A-Za-z_]\w*$")
NOT_A_FUNCTION = {"alignas", "decltype", "explicit", "noexcept", "requires", "static_assert"}  # and yet before a bracket
NOT_DATA = {"class", "enum", "friend", "static", "static_assert", "struct", "template", "typedef", "union", "using"}
BRACKETS = {"(": ")", "[": "]", "{": "}", "<": ">"}


@dataclasses.dataclass
class Class:
    path: tuple  # namespaces, the classes around it and its own name
    local: bool  # in an anonymous namespace
    members: list  # the names of its data


@dataclasses.dataclass
class Function:
    scope: tuple  # namespaces and classes that have it in their braces
    names: tuple  # what is written: classes or namespaces, and its own name
    parameters: int
    in_class: bool  # in the braces of a class
    local: bool  # in an anonymous namespace, or static
    defined: bool  # with a body, defaulted, deleted or pure: needs no other definition


class Outline:
    """The classes and functions of a file."""

    def __init__(self, text):
        self.classes = []
        self.functions = []
        self._code = [found.group() for found in TOKEN.finditer(text) if not found.group("left_out")]
        self._read(0, (), False, None)

    def _read(self, at, scope, local, inside):
        """Reads the statements of a scope up to its closing bracket, whose place it returns. `inside`: its Class, or None."""
        code = self._code
        head = []  # the statement so far
        while at < len(code):
            token = code[at]
            if token == "}":
                return at
            if token == ";":
                self._statement(head, scope, local, inside, False)
                head = []
            elif token == ":" and head in (["public"], ["protected"], ["private"]):
                head = []
            elif token in "([":
                end = closing(code, at)
                head += code[at:end + 1]
                at = end
            elif token == "{":
                at, head = self._braces(at, head, scope, local, inside)
            else:
                head.append(token)
            at += 1
        return at

    def _braces(self, at, head, scope, local, inside):
        """Reads what stands in the braces at `at`. Returns their end, and the statement that goes on after them."""
        start = without_template(head)
        if start and start[0] in ("namespace", "inline") and "namespace" in start[:2]:
            names = tuple(name for name in start[start.index("namespace") + 1:] if NAME.match(name))
            return self._read(at + 1, scope + names, local or not names, inside), []
        if start[:1] == ["extern"] and len(start) == 2:
            return self._read(at + 1, scope, local, inside), []
        if start and start[0] in ("class", "struct", "union"):
            made = Class(scope + class_names(start), local, [])
            self.classes.append(made)
            return self._read(at + 1, made.path, local, made), ["}"]
        end = closing(self._code, at)
        is_function = bool(start) and start[0] != "enum" and declarator(start) is not None
        if is_function and self._code[end + 1:end + 2] not in ([","], ["{"]):  # not the braces of a member's start value
            self._statement(head, scope, local, inside, True)
            return end, []
        return end, head + ["{", "}"]

    def _statement(self, head, scope, local, inside, body):
        head = without_template(head)
        if not head or head[0] in ("using", "typedef", "friend", "template", "static_assert"):
            return
        function = declarator(head)
        if function is None or ("constexpr" in head and not body):  # a variable that is made with brackets
            if inside is not None and head[0] not in NOT_DATA and scope == inside.path:
                inside.members += data_names(head)
            return
        names, bracket = function
        end = closing(head, bracket)
        self.functions.append(Function(
            scope, names, count_parameters(head[bracket + 1:end]), inside is not None,
            local or (inside is None and "static" in head[:bracket]), body or "=" in head[end:]))


def closing(code, at):
    """The place of the bracket that closes the one at `at`."""
    opened, closed = code[at], BRACKETS[code[at]]
    depth = 0
    for place in range(at, len(code)):
        depth += (code[place] == opened) - (code[place] == closed)
        if depth == 0:
            return place
    return len(code) - 1


def without_template(head):
    """The statement without template<...> and requires before it."""
    while head[:2] == ["template", "<"]:
        head = head[closing(head, 1) + 1:]
        if head[:2] == ["requires", "("]:
            head = head[closing(head, 1) + 1:]
    return head


def class_names(head):
    """The names of the class that `head` begins to define, a and b of a<x>::b; none if it has no name."""
    end = 1
    while end < len(head) and head[end] != ":":
        after = closing(head, end) + 1 if head[end] in "(<" else end + 1
        if head[end] == "<" and head[after:after + 1] != ["::"]:
            break  # a specialization
        end = after
    named = [token for token in head[:end] if token not in ("final", "alignas")]
    return qualified(named, len(named) - 1) if len(named) > 1 else ()


def qualified(head, last):
    """The names written at the end of `head[:last + 1]`: a, b and c of a::b<x>::c."""
    names = [head[last]]
    place = last - 1
    while place > 0 and head[place] == "::":
        place -= 1
        if head[place] == ">":
            while head[place] != "<":
                place -= 1
            place -= 1
        if not NAME.match(head[place]):
            break
        names.insert(0, head[place])
        place -= 1
    return tuple(names)


def declarator(head):
    """(the names of the function that `head` declares, the place of its bracket), or None."""
    depth = 0  # of angle brackets
    for place, token in enumerate(head):
        if token == "operator":
            bracket = head.index("(", place + 2)
            joined = head[:place] + ["operator" + "".join(head[place + 1:bracket])]
            return qualified(joined, place), bracket
        if token in "<>":
            depth += 1 if token == "<" else -1
        elif token == "=" and depth == 0:
            return None
        elif token == "(" and depth == 0 and place > 0:
            last = place - 1
            if head[last] == ">":  # f<int>(...)
                while last > 0 and head[last] != "<":
                    last -= 1
                last -= 1
            name = head[last]
            if last >= 0 and NAME.match(name) and name not in NOT_A_FUNCTION and head[place + 1] != "*":  # (*: a pointer to a function
                if last > 0 and head[last - 1] == "~":
                    return qualified(head[:last - 1] + ["~" + name], last - 1), place
                return qualified(head, last), place
    return None


def split_at_commas(code):
    """The parts of `code` between the commas that no bracket holds."""
    parts, depth = [[]], 0
    for token in code:
        depth += (token in "([{<") - (token in ")]}>")
        if token == "," and depth == 0:
            parts.append([])
        else:
            parts[-1].append(token)
    return [part for part in parts if part]


def count_parameters(code):
    return len([part for part in split_at_commas(code) if part != ["void"]])


def data_names(head):
    """The names of the variables that a statement declares."""
    names = []
    for part in split_at_commas(head):
        end = next((place for place, token in enumerate(part) if token in ("=", "{", "[", ":")), len(part))
        if end > 0 and NAME.match(part[end - 1]):
            names.append(part[end - 1])
    return names

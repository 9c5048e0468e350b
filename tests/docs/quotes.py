"""Compares quotes and defaults in a page with the program. Comments in the page, which a reader does not see, mark it:

  the client says `no force: the clutch is held` <!-- says: client -->
      The code between backticks before the mark. WHERE is a command (its output has these words; {scratch} is an empty folder) or one or more folders or files
      (their strings have them). Numbers and names may differ; of the words between them at least six of ten stand there in runs of three
      or more, for a program also puts in words that it has from elsewhere.
  <!-- says: WHERE -->
      On a line of its own, before a code block: every line of it. Before a table: all that stands between backticks in its first column
      and has two words or more. Before a table with a number behind WHERE, as in <!-- says: client 2 -->: in that column.
  0.1 s <!-- default: feltwire-client --hold-time 0.1 -->
      The program's --help has this default, and the page has it in the line, before the mark.
  <!-- defaults: feltwire-server -->
      Before a table: where its first column names one option, and --help has a default of it ("Default: 1.5", too), the column `default`
      or `usual value` has the same. With `keys` at the end, the first column names keys of an option, as --help lists them.
  <!-- defaults: core/scene_file/scene.fbs ToolBody coupling=ToolCoupling -->
      Before a table: the first column names fields of a table of a schema, and the column `default` has their defaults.
      `coupling.stiffness` is a field of the second table. With a number at the end, that column names the fields.
  <!-- defaults: words -->
      Before a table whose defaults are words, or numbers with a file in each row. A table with a column `default` needs one of these marks.
"""

import re
import shlex
import tempfile

MARK = re.compile(r"<!--\s*(says|default|defaults):\s*(.*?)\s*-->")
STRING = re.compile(r'R"\((.*?)\)"|"((?:[^"\\\n]|\\.)*)"', re.S)
JOINED = re.compile(r'"\s*\n?\s*"')
SOURCES = {".cpp", ".hpp", ".c", ".h", ".py", ".ts", ".js", ".mjs", ".html", ".json", ".fbs", ""}
ESCAPES = {"n": "\n", "t": "\t", '"': '"', "'": "'", "\\": "\\"}


def words_of(text):
    return re.sub(r"\s+", " ", text).strip().split(" ")


def spans(text):
    return re.findall(r"`([^`]+)`", text)


def cells(line):
    return [cell.strip() for cell in re.split(r"(?<!\\)\|", line.strip().strip("|"))]


def is_put_in(word):
    """Whether a program puts this word in, as far as one can see: a number, a name of a file or of a field, something in quotes."""
    return bool(re.search(r"\d|^'.*'|[\[\]/]|\w\.\w", word))


class Marks:
    def __init__(self, source, programs):
        self.source, self.programs, self.texts, self.count = source, programs, {}, 0

    def strings(self, path):
        """All strings of the sources in a folder, those that the compiler joins in one piece."""
        text = []
        for file in [path] if path.is_file() else sorted(path.rglob("*")):
            if not file.is_file() or file.suffix not in SOURCES or "node_modules" in file.parts:
                continue
            source = file.read_text(encoding="utf-8", errors="replace")
            if file.suffix not in {".cpp", ".hpp", ".c", ".h"}:
                text.append(source)
                continue
            for raw, plain in STRING.findall(JOINED.sub("", source)):
                text.append(raw or re.sub(r"\\(.)", lambda escape: ESCAPES.get(escape.group(1), escape.group(0)), plain))
        return "\n".join(text)

    def text(self, where):
        """All text that this place can say; None where there is no such place."""
        if where not in self.texts:
            if where.startswith("feltwire-"):
                with tempfile.TemporaryDirectory() as scratch:
                    command = [word.replace("{scratch}", scratch) for word in shlex.split(where)]
                    found = self.programs.output(*command)[1] if self.programs.there(command[0]) else None
            else:
                paths = [self.source / name for name in where.split(" ")]
                found = "\n".join(self.strings(path) for path in paths) if all(path.exists() for path in paths) else None
            self.texts[where] = None if found is None else " ".join(words_of(found))
        return self.texts[where]

    def missing(self, quote, where):
        """The fault of a quote; None: it is there."""
        self.count += 1
        text = self.text(where)
        if text is None:
            return f"there is no {where} that could say anything"
        segments, words, found = [[]], 0, 0
        for word in words_of(quote.replace("...", " 0 ")):
            if is_put_in(word):
                segments.append([])
            elif word:
                segments[-1].append(word)
        for segment in segments:
            words += len(segment)
            i = 0
            while i < len(segment):
                longest = 0
                while i + longest < len(segment) and " ".join(segment[i:i + longest + 1]) in text:
                    longest += 1
                found += longest if longest >= min(3, len(segment)) else 0
                i += max(1, longest)
        if words == 0 or found * 10 < words * 6:
            return f"'{quote}' is not what {where} says"
        return None

    def default(self, program, option):
        """As --help has it; None: it has none."""
        command = shlex.split(program)
        text = self.programs.help(*command) if self.programs.there(command[0]) else None
        line = re.search(rf"(?m)^\s+{re.escape(option)}(?![\w-])([^\n]*)((?:\n {{20,}}[^\n]*)*)", text or "")
        value = re.search(r"^ [A-Z\[\],:]+=(\S+)", line.group(1)) or re.search(r"Default: ([\d.]+)", line.group(0)) if line else None
        return value.group(1).rstrip(".,") if value else None

    def same(self, said, value):
        """Whether a text has this number or word."""
        try:
            number = float(value)
        except ValueError:
            return value == said or value in re.split(r"[\s`|,;()]+", said)
        return any(float(said) == number for said in re.findall(r"[-+]?\d+(?:\.\d+)?(?:e[-+]?\d+)?", said))

    def wrong_default(self, program, option, value, before):
        self.count += 1
        real = self.default(program, option)
        if real is None or not self.same(real, value):
            return f"the default of {program} {option} is {real}, not {value}"
        if not self.same(before, value):
            return f"the page does not say the default {value} of {option} before its mark"
        return None

    def schema_default(self, file, tables, field):
        """The default of a field, `a.b` for one of a table within; None: it has none."""
        before, _, name = field.rpartition(".")
        table = dict(word.split("=") for word in tables if "=" in word).get(before) if before else tables[0]
        body = re.search(rf"(?m)^table {table} {{(.*?)}}", (self.source / file).read_text(encoding="utf-8"), re.S) if table else None
        value = re.search(rf"(?:^|[\s;]){re.escape(name)}: *\w+ *= *([^;]+);", body.group(1)) if body else None
        return None if value is None or value.group(1).strip() == "nan" else value.group(1).strip()

    def check_schema(self, rows, what):
        """Checks a table of a page, rows of (line, cells), against a schema."""
        file, *tables = what.split(" ")
        column = int(tables.pop()) if tables[-1].isdigit() else 1
        (_, head), *rows = rows
        counted = self.count
        for number, row in rows:
            fields, said = spans(row[column - 1]), row[head.index("default")]
            values = said.split(",") if len(fields) > 1 else [said]
            for field, shown in zip(fields, values if len(values) == len(fields) else []):
                value = self.schema_default(file, tables, field)
                shown = re.sub(r"^no$", "false", shown.strip('` "'))
                # A zero may stand for what is computed then: "a sixth of the surface".
                if value is None or (value in ("0", "0.0") and not re.match(r"[-\d]", shown)):
                    continue
                self.count += 1
                if not self.same(shown, value):
                    yield number, f"the default of {field} in {file} is {value}, not {shown}"
        if self.count == counted:
            yield rows[0][0], f"no default of {what} is in this table"

    def check(self, page):
        """(line, what is wrong)"""
        lines, fenced = page.lines, False
        for number, line in enumerate(lines, 1):
            fenced ^= line.strip().startswith("```")
            if fenced:
                continue
            if line.startswith("|") and "default" in cells(line) and not re.match(r"<!-- defaults: ", lines[number - 2]):
                yield number, "this table has defaults and no mark `defaults` before it (tests/docs/quotes.py)"
            for mark in MARK.finditer(line):
                kind, what = mark.groups()
                before = line[:mark.start()]
                if kind == "default":
                    program, option, value = re.match(r"(.*) (\S+) (\S+)$", what).groups()
                    yield from ((number, wrong) for wrong in [self.wrong_default(program, option, value, before)] if wrong)
                elif before.strip() or spans(lines[number - 2])[-1:] and lines[number - 2].rstrip().endswith("`"):
                    quoted = (spans(before) or spans(lines[number - 2]))[-1:] or ["nothing between backticks"]
                    yield from ((number, wrong) for wrong in [self.missing(quoted[0], what)] if wrong)
                else:
                    yield from self.check_below(lines, number, kind, what)

    def check_below(self, lines, number, kind, what):
        """Checks the block or the table below a mark on a line of its own."""
        below = number
        while below < len(lines) and (not lines[below].strip() or MARK.fullmatch(lines[below].strip())):
            below += 1
        if below < len(lines) and lines[below].startswith("```"):
            for at in range(below + 1, len(lines)):
                if lines[at].startswith("```"):
                    return
                if lines[at].strip() and (wrong := self.missing(lines[at], what)):
                    yield at + 1, wrong
        head = cells(lines[below]) if below < len(lines) and lines[below].startswith("|") else None
        if head is None:
            yield number, "neither a code block nor a table stands below the mark"
            return
        if kind == "defaults" and what == "words":
            return
        keys = kind == "defaults" and what.endswith(" keys")
        what = what.removesuffix(" keys")
        if kind == "defaults" and ".fbs" in what:
            end = next((at for at in range(below, len(lines)) if not lines[at].startswith("|")), len(lines))
            yield from self.check_schema([(at + 1, cells(lines[at])) for at in range(below, end) if at != below + 1], what)
            return
        column = 1
        if kind == "says" and (named := re.match(r"(.*) (\d+)$", what)):
            what, column = named.group(1), int(named.group(2))
        for at in range(below + 2, len(lines)):
            if not lines[at].startswith("|"):
                return
            row = cells(lines[at])
            if kind == "says":
                for quote in spans(row[column - 1]):
                    if len(words_of(quote)) > 1 and (wrong := self.missing(quote, what)):
                        yield at + 1, wrong
                continue
            options = spans(row[0])[:1] if keys else re.findall(r"(--[a-z][\w-]*)", row[0])
            value = self.default(what, options[0]) if len(options) == 1 else None
            if value is not None:
                self.count += 1
                said = row[head.index("default" if "default" in head else "usual value")]
                if not self.same(said, value):
                    yield at + 1, f"the default of {what} {options[0]} is {value}, not {said}"

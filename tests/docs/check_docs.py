#!/usr/bin/env python3
"""Checks that what the documents tell people to type exists.

Every command of README.md, SECURITY.md, CONTRIBUTING.md and docs/*.md that runs one of our programs or scripts, in a code block or
with its options in a sentence: the program has that subcommand and those options and none that it requires is missing (it is asked with --help), the files of the repository that it
names are there, a filter of the benchmarks finds some, and a page that uses a program which the usual build
leaves out says how to build it first. Every table has one number of cells in all its rows. A link to a file or to a heading leads
somewhere. A path of the repository between backticks is there. docs/README.md has a link to every page of docs. A code block that is said to be of a file (```json scenes/tutorial/1_table.json) stands in that file, line by line.

Quotes of a program and its defaults, which the pages mark, are the program's (quotes.py).

usage: check_docs.py SOURCE_FOLDER BIN_FOLDER
"""

import pathlib
import re
import shlex
import subprocess
import sys

sys.dont_write_bytecode = True
import quotes  # noqa: E402

USUALLY_BUILT = {"feltwire-server", "feltwire-client", "feltwire-lab", "feltwire-view", "feltwire-follower", "feltwire-bundle"}
PROGRAM = re.compile(r"^(?:build/[a-z]+/bin/)?(feltwire-[a-z]+)$")


class Page:
    def __init__(self, path, source):
        self.name = str(path.relative_to(source))
        self.lines = path.read_text(encoding="utf-8").split("\n")

    def blocks(self):
        """(number, line) of code: in fences without a language or of a shell, or indented by four spaces."""
        fence = None
        for number, line in enumerate(self.lines, 1):
            stripped = line.strip()
            if stripped.startswith("```"):
                fence = stripped[3:].strip() if fence is None else None
                continue
            if fence is not None:
                if fence in ("", "sh", "bash", "shell", "console"):
                    yield number, line
            elif line.startswith("    "):
                yield number, line

    def commands(self):
        """(number of its first line, words, whether in a sentence), continued lines joined, no comments."""
        begun, text = 0, ""
        for number, line in self.blocks():
            text += " " + line.strip().lstrip("$ ")
            begun = begun or number
            if text.endswith("\\"):
                text = text[:-1]
                continue
            try:
                words = shlex.split(text, comments=True)
            except ValueError:
                words = []
            if words:
                yield begun, words, False
            begun, text = 0, ""
        for number, line in enumerate(self.lines, 1):
            for text in re.findall(r"`((?:build/[a-z]+/bin/)?feltwire-[a-z]+ [^`]*--[^`]*)`", line):
                try:
                    yield number, shlex.split(text), True
                except ValueError:
                    pass


def simple_commands(words):
    """Parts of a pipeline or a list, without VARIABLE=value in front."""
    part = []
    for word in words + ["|"]:
        if word in ("|", "||", "&&", "&", ";"):
            while part and re.match(r"^[A-Za-z_]+=", part[0]):
                part.pop(0)
            if part[:2] == ["nice", "-n"]:
                part = part[3:]
            if part:
                yield part
            part = []
        else:
            part.append(word)


class Programs:
    def __init__(self, folder):
        self.folder, self.asked = folder, {}

    def there(self, program):
        return (self.folder / program).is_file()

    def output(self, *command):
        if command not in self.asked:
            done = subprocess.run([str(self.folder / command[0]), *command[1:]], stdin=subprocess.DEVNULL,
                                  stdout=subprocess.PIPE, stderr=subprocess.STDOUT, text=True, timeout=120, check=False)
            self.asked[command] = (done.returncode, done.stdout)
        return self.asked[command]

    def help(self, *command):
        """Text of --help-all, or of --help where that has every option; None where there is no such (sub)command."""
        for option in ("--help-all", "--help"):
            status, text = self.output(*command, option)
            if status == 0:
                return text
        return None


def subcommands(programs, words):
    """The words of a command that are subcommands: those that have a help of their own."""
    command = [words[0]]
    for word in words[1:]:
        if word.startswith("-") or programs.help(*command, word) in (None, programs.help(*command)):
            break
        command.append(word)
    return command


def check_program(programs, words, built_on_page, quoted):
    program = PROGRAM.match(words[0]).group(1)
    if words[0].startswith("build/release/"):
        yield f"'{words[0]}' has a path; the quickstart puts the programs into PATH"
    words = [program] + words[1:]
    if not quoted and program not in USUALLY_BUILT and program not in built_on_page:
        yield f"{program} is used before the page says how to build it (cmake --build ... --target {program})"
    if not programs.there(program):
        if program in USUALLY_BUILT:
            yield f"there is no program {program}"
        return
    command = subcommands(programs, words)
    text = programs.help(*command)
    if text is None:
        yield f"'{' '.join(command)} --help' fails"
        return
    if program == "feltwire-lab" and len(command) == 1 and not words[1:2] == ["--help"]:
        yield f"feltwire-lab has no command {words[1] if len(words) > 1 else '(none given)'}"
    whole = programs.help(program) or ""
    for word in words[len(command):]:
        option = word.split("=")[0]
        if not re.match(r"^--[a-z]", option) or option == "--help":
            continue
        if not re.search(rf"{re.escape(option)}(?![a-z0-9_-])", text + whole):
            yield f"{' '.join(command)} has no option {option}"
    if not any("..." in word for word in words):
        required = set(re.findall(r"(?m)^\s+(--[a-z][\w-]*) [^\n]*\bREQUIRED\b", text))
        given = {word.split("=")[0] for word in words}
        ends = given & {"--help", "--version"}
        # A sentence may name one option of a command. Where it names one that is required, it means the whole command.
        if not ends and (required & given or not quoted):
            for option in sorted(required - given):
                yield f"{' '.join(command)} needs {option}"
    for word in words:
        if word.startswith("--benchmark_filter="):
            status, listed = programs.output(program, word, "--benchmark_list_tests")
            if status != 0 or not listed.strip() or "Failed to match" in listed:
                yield f"no benchmark matches {word}"


def check_files(source, words):
    for word in words:
        if re.match(r"^(scripts|scenes|docker|tests)/[\w./-]+$", word) and not (source / word).exists():
            yield f"there is no {word}"


def check_tables(page):
    cells, fenced = None, False
    for number, line in enumerate(page.lines, 1):
        fenced ^= line.strip().startswith("```")
        if fenced or not line.startswith("|"):
            cells = None
            continue
        count = len(re.sub(r"\\\|", "", line).strip().strip("|").split("|"))
        if cells is None:
            below = page.lines[number] if number < len(page.lines) else ""
            if not re.match(r"^\|[\s:|-]+\|$", below):
                yield number, "a table begins here without a line of dashes below its head"
        elif count != cells:
            yield number, f"{count} cells where the table has {cells}"
        cells = count


def check_excerpts(source, page):
    """A block whose first line names a file stands in it."""
    begun, file, block = 0, None, []
    for number, line in enumerate(page.lines, 1):
        fence = re.match(r"^```\w*\s*(\S*)$", line.rstrip())
        if fence and begun == 0:
            begun, file, block = number, fence.group(1), []
        elif fence:
            if file and not (source / file).is_file():
                yield begun, f"there is no {file}"
            elif file and "\n".join(block) + "\n" not in (source / file).read_text(encoding="utf-8"):
                yield begun, f"the block is not in {file}"
            begun = 0
        elif begun:
            block.append(line)


def check_paths(source, page):
    """A path between backticks is there: core/base/ring, which has no ending, and core/bounding/*.hpp, too."""
    fenced, folders = False, [folder.name for folder in source.iterdir() if folder.is_dir() and folder.name not in ("build", ".git")]
    begins = "|".join(re.escape(name) for name in folders)
    for number, line in enumerate(page.lines, 1):
        fenced ^= line.strip().startswith("```")
        for path in [] if fenced else re.findall(rf"`((?:{begins}|schema)/[\w.*/-]+)`", line):
            if re.search(r"/[A-Z]{4,}(\.|$)", path):
                continue  # a word for any name
            if not any(source.glob(path.rstrip("/"))) and not any(source.glob(path + ".*")):
                yield number, f"there is no {path}"


def anchors(path):
    """Of the headings of a page, as GitHub names them."""
    text = re.sub(r"```.*?```", "", path.read_text(encoding="utf-8"), flags=re.S)
    names = []
    for heading in re.findall(r"^#+ (.*)$", text, re.M):
        name = re.sub(r"[^\w\- ]", "", heading.strip().lower()).replace(" ", "-")
        names.append(name if name not in names else f"{name}-{names.count(name)}")
    return names


def check_index(source):
    """Every page stands in the list of all pages."""
    index = source / "docs" / "README.md"
    text = index.read_text(encoding="utf-8")
    for path in sorted((source / "docs").rglob("*.md")):
        page = path.relative_to(source / "docs")
        if path != index and f"({page})" not in text:
            yield f"docs/README.md does not list {page}"


def check_metrics(source):
    """Metrics that documents name and the server does not have."""
    ours = set(re.findall(r'"(feltwire_[a-z_]+)"', (source / "server/app/prometheus_metrics.cpp").read_text()))
    for path in (source / "docs/grafana.json", source / "docs/live_page.md", source / "docs/alerts.yml"):
        named = set(re.findall(r"\bfeltwire_[a-z_]+\b", path.read_text()))
        # The series of a histogram.
        named = {re.sub(r"(?<=_seconds)_(bucket|sum|count)$", "", metric) for metric in named}
        for metric in sorted(named - ours):
            yield f"{path.relative_to(source)}: the server has no metric {metric}"
        if not named:
            yield f"{path.relative_to(source)}: names no metric: the check reads nothing"


def check_links(source, page, path):
    fenced = False
    for number, line in enumerate(page.lines, 1):
        fenced ^= line.strip().startswith("```")
        for target in [] if fenced else re.findall(r"\]\(([^)\s]+)\)", line):
            if re.match(r"^[a-z]+:", target):
                continue
            file, _, anchor = target.partition("#")
            there = (path.parent / file).resolve() if file else path
            if not there.exists() or source not in [there, *there.parents]:
                yield number, f"the link to {target} leads nowhere"
            elif anchor and there.suffix == ".md" and anchor not in anchors(there):
                yield number, f"there is no heading {anchor} in {there.relative_to(source)}"


def main():
    source, folder = pathlib.Path(sys.argv[1]).resolve(), pathlib.Path(sys.argv[2])
    programs = Programs(folder)
    found, commands = [], 0
    pages = [source / "README.md", source / "SECURITY.md", source / "CONTRIBUTING.md", source / "protocol/PROTOCOL.md",
             *sorted((source / "docs").rglob("*.md"))]
    marks = quotes.Marks(source, programs)
    for page in (Page(path, source) for path in pages):
        built = set()
        for number, words, quoted in page.commands():
            for part in simple_commands(words):
                if part[0] == "cmake" and "--target" in part:
                    built.update(part[part.index("--target") + 1:])
                wrong = list(check_files(source, part)) if part[0][0] in "bcdfst" else []
                if PROGRAM.match(part[0]):
                    commands += 1
                    wrong += check_program(programs, part, built, quoted)
                found += [f"{page.name}:{number}: {what}" for what in wrong]
        for number, what in [*check_tables(page), *check_excerpts(source, page), *check_links(source, page, source / page.name), *check_paths(source, page),
                             *marks.check(page)]:
            found.append(f"{page.name}:{number}: {what}")
    found += [*check_index(source), *check_metrics(source)]
    print("\n".join(found + [f"{commands} commands of our programs, {marks.count} quotes and defaults, {len(found)} wrong"]))
    if commands == 0 or marks.count == 0:
        print("no command or no quote was found: the check reads nothing")
    return 1 if found or commands == 0 or marks.count == 0 else 0


if __name__ == "__main__":
    sys.exit(main())

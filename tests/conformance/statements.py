"""The statements of PROTOCOL.md that bind an implementation: its sentences with a word of obligation, and all of the lists of duties."""
import re
from pathlib import Path

TEXT = Path(__file__).resolve().parents[2] / "protocol/PROTOCOL.md"
WORDS = re.compile(r"\b(must|never|refused?|refuses|drops?|dropped|malformed|ignored?|ignores|exactly|only|at most|evicts?|closes|no other)\b",
                   re.IGNORECASE)
DUTIES = ("A client must", "A server must", "What a receiver checks, in this exact order")
END = "Errata"


def blocks():
    """(heading, text) of each paragraph, item of a list and cell of a table, without links, examples and errata."""
    heading, lines = "", []

    def flush():
        if lines:
            yield heading, " ".join(lines)
            lines.clear()
    for line in TEXT.read_text(encoding="utf-8").splitlines():
        ends = line.startswith(("    ", "#", "|", "- ")) or not line.strip()
        if ends:
            yield from flush()
        line = re.sub(r"\[([^\]]+)\]\([^)]+\)", r"\1", line)  # a link is its text
        if line.startswith("#"):
            heading = line.strip("# ")
            if heading == END:
                break
        elif line.startswith("|"):
            if not re.fullmatch(r"\|[-| ]+\|", line):
                yield from ((heading, cell.strip().replace("\0", "|")) for cell in line.strip("|").replace("\\|", "\0").split("|"))
        elif line.strip() and not line.startswith("    "):
            lines.append(line.removeprefix("- ").strip())
    yield from flush()


def sentences():
    """The statements, each once, in the order of the text."""
    found = {}
    for heading, text in blocks():
        for sentence in re.split(r"(?<=[.;])\s+(?=[A-Z`*(\[])", text):
            if WORDS.search(sentence) or (heading in DUTIES and len(sentence) > 25):
                found.setdefault(sentence, len(found))
    return list(found)


def plain():
    """The whole text with single spaces, as quotations are searched in it."""
    return " ".join(text for _, text in blocks())

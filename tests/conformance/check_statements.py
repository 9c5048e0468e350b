#!/usr/bin/env python3
"""Checks that each binding statement of PROTOCOL.md stands in statements.md with its checks, or with a reason why none sees it.

A changed sentence of the text makes it fail, with the line. So do a check that quotes what the text does not say, and a row that names
a check that is not there.

usage: check_statements.py
"""
import re
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import checks  # noqa: E402
import every_check  # noqa: E402,F401
import statements  # noqa: E402

TABLE = Path(__file__).resolve().parent / "statements.md"


def rows():
    """statement -> its second cell."""
    lines = [line for line in TABLE.read_text(encoding="utf-8").splitlines() if line.startswith("| ")][1:]
    return dict(line.strip("| ").rsplit(" | ", 1) for line in lines)


def line_of(sentence):
    """Where the text has the beginning of a sentence."""
    words = re.compile(r"\s+".join(map(re.escape, sentence.split()[:5])))
    found = words.search(statements.TEXT.read_text(encoding="utf-8"))
    return found.string[:found.start()].count("\n") + 1 if found else 0


def named(cell, known):
    """The checks that a cell names; `S-201 to S-218` are all from the first to the last."""
    found = set()
    for first, last in re.findall(r"\b([SC]-\d{3})(?: to ([SC]-\d{3}))?", cell):
        found |= {one for one in known if first <= one <= last} if last else {first}
    return found


def problems():
    known = {one.identity: one for side in checks.REGISTRY.values() for one in side}
    table, text = rows(), statements.plain()
    for sentence in statements.sentences():
        if sentence not in table:
            yield f"PROTOCOL.md, line {line_of(sentence)}: statements.md has no row for: {sentence}"
    for sentence in set(table) - set(statements.sentences()):
        yield f"statements.md quotes what PROTOCOL.md does not say: {sentence}"
    for one in known.values():
        if one.sentence not in text:
            yield f"{one.identity} quotes what PROTOCOL.md does not say: {one.sentence}"
    for sentence, cell in table.items():
        for identity in named(cell, known) - set(known):
            yield f"statements.md names {identity}, which is no check, for: {sentence}"
        if not cell.strip():
            yield f"statements.md says nothing of: {sentence}"


def main():
    found = list(problems())
    print("\n".join(found) if found else f"{len(rows())} statements: each has its checks or a reason")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())

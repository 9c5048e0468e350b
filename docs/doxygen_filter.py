#!/usr/bin/env python3
"""Shows Doxygen comments of a header that it would not see, and prints the header with them.

They are the comment at the head of the file, which stands under `#pragma once`, and a comment behind a member of a class or an enum, with
the lines that continue it in the same column. An @ before a capital letter, as in haply@PORT, is a sign and no command of Doxygen. Each
line keeps its number. docs/Doxyfile runs this on each header: doxygen_filter.py FILE
"""

import pathlib
import re
import sys

BEHIND = re.compile(r"^(?P<code>\s*[^\s/].*?\S)(?P<gap>\s+)// (?!NOLINT)(?P<text>.*)$")
STATEMENT = re.compile(r"^\s*(return|if|for|while|else|using|namespace|#)\b")


def shown(lines):
    head = len(lines) > 1 and lines[0].startswith("#pragma once") and lines[1].startswith("// ")
    column = None
    for number, line in enumerate(lines):
        if head and number == 0:
            line = "/// @file"
        elif head and line.startswith("//"):
            line = "/" + line
        else:
            head = False
            behind = BEHIND.match(line)
            enumerator = re.match(r"^\s*[a-z]\w*\s*$", line.split("//")[0])
            if behind and not STATEMENT.match(line) and (behind["code"][-1] in ";," or enumerator):
                column = line.index("// ", behind.end("code"))
                line = f"{behind['code']}{behind['gap']}///< {behind['text']}"
            elif column is not None and re.match(r"^\s*// ", line) and line.index("//") == column:
                line = line.replace("// ", "///< ", 1)
            else:
                column = None
        yield re.sub(r"(?<!\\)@(?=[A-Z])", r"\\@", line)


if __name__ == "__main__":
    print("\n".join(shown(pathlib.Path(sys.argv[1]).read_text(encoding="utf-8").split("\n"))), end="")

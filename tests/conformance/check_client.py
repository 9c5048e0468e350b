#!/usr/bin/env python3
"""Checks feltwire-client against protocol/PROTOCOL.md from outside: check_client.py BIN_FOLDER [ID ...], or --list."""
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import checks  # noqa: E402
import every_check  # noqa: E402,F401
from client_process import Client  # noqa: E402


def main(words):
    if words[:1] == ["--list"]:
        for one in checks.REGISTRY["client"]:
            print(f"{one.identity}  {one.sentence}")
        return 0
    if not words:
        sys.exit(__doc__)
    subject = Client() if words[0] == "--model" else Client(Path(words[0]) / "feltwire-client")
    wanted, failed = words[1:], 0
    try:
        for one in sorted(checks.REGISTRY["client"], key=lambda one: one.identity):
            if not wanted or one.identity in wanted:
                passed, seen = checks.judge_program(one, subject)
                checks.report(one, passed, seen)
                failed += not passed
    finally:
        subject.close()
    print(f"{failed} checks failed" if failed else "all checks passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

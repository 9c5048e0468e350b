#!/usr/bin/env python3
"""Checks feltwire-server against protocol/PROTOCOL.md from outside: check_server.py BIN_FOLDER [ID ...], or --list."""
import sys
from pathlib import Path

sys.dont_write_bytecode = True
import checks  # noqa: E402
import every_check  # noqa: E402,F401
from server_process import Server  # noqa: E402


def main(words):
    if words[:1] == ["--list"]:
        for one in checks.REGISTRY["server"]:
            print(f"{one.identity}  {one.sentence}")
        return 0
    if not words:
        sys.exit(__doc__)
    program, wanted, failed = Path(words[0]) / "feltwire-server", words[1:], 0
    server = Server(program)
    try:
        server.begin_silence()
        for one in sorted(checks.REGISTRY["server"], key=lambda one: one.identity):
            if not wanted or one.identity in wanted:
                passed, seen = checks.judge_program(one, server)
                checks.report(one, passed, seen)
                failed += not passed
    finally:
        server.close()
    print(f"{failed} checks failed" if failed else "all checks passed")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

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
        checks.list_checks("server")
        return 0
    if not words:
        sys.exit(__doc__)
    server = Server(Path(words[0]) / "feltwire-server")
    try:
        server.begin_silence()
        return checks.run("server", server, words[1:])
    finally:
        server.close()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

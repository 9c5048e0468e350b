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
        checks.list_checks("client")
        return 0
    if not words:
        sys.exit(__doc__)
    client = Client() if words[0] == "--model" else Client(Path(words[0]) / "feltwire-client")
    try:
        return checks.run("client", client, words[1:])
    finally:
        client.close()


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

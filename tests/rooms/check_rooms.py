#!/usr/bin/env python3
"""Checks that folders include each other in one direction only.

The CMakeLists.txt of core/, protocol/, server/, client/, gateway/ and sim/ list their rooms from the ground up, each with the rooms
that it USES. A room may include headers of itself and of those; it may use only rooms that are listed before it, so that
no circle can be; and the client uses nothing of the server.

usage: check_rooms.py SOURCE_FOLDER
"""

import pathlib
import re
import sys

FLOORS = ("core", "protocol", "server", "client", "gateway", "sim")  # from the ground up, as CMakeLists.txt adds them
FORBIDDEN = {("client", "server")}


def declared(source):
    """Room -> rooms that it uses, in the order of declaration."""
    rooms = {}
    for floor in FLOORS:
        text = (source / floor / "CMakeLists.txt").read_text(encoding="utf-8")
        for name, body in re.findall(r"^feltwire_room\((\S+)([^)]*)\)", text, re.M):
            uses = re.search(r"\bUSES((?:\s+[\w/]+)*?)(?=\s+(?:LINKS|PRIVATE|SOURCES|SCHEMAS)\b|\s*$)", body)
            rooms[f"{floor}/{name.rstrip(')')}"] = uses.group(1).split() if uses else []
    return rooms


def included(source):
    """(file, line, included file) of every include of our own headers."""
    for floor in FLOORS:
        for file in sorted((source / floor).rglob("*.[ch]pp")):
            for number, line in enumerate(file.read_text(encoding="utf-8").split("\n"), 1):
                found = re.match(r'#include "((?:%s)/[^"]+)"' % "|".join(FLOORS), line)
                if found:
                    yield file.relative_to(source), number, pathlib.PurePath(found.group(1))


def main():
    source = pathlib.Path(sys.argv[1])
    rooms = declared(source)
    wrong = []
    for place, (room, uses) in enumerate(rooms.items()):
        below = list(rooms)[:place]
        wrong += [f"{room}: uses {used}, which is not listed before it" for used in uses if used not in below]
        wrong += [f"{room}: may not use {used}" for used in uses
                  if (room.split("/")[0], used.split("/")[0]) in FORBIDDEN]
    seen = {room: set() for room in rooms}
    for file, number, header in included(source):
        room, other = str(file.parent), str(header.parent)
        if room not in rooms:
            wrong.append(f"{file}: its folder is no room of a CMakeLists.txt")
            continue
        seen[room].add(other)
        if other != room and other not in rooms[room]:
            wrong.append(f"{file}:{number}: {room} includes {header}, and does not name {other} in USES; include something "
                         "below, or add the room to the CMakeLists.txt if it stands below")
    wrong += [f"{room}: names {used} in USES and includes nothing of it; remove it"
              for room, uses in rooms.items() for used in uses if used not in seen[room]]
    print("\n".join(wrong) or f"{len(rooms)} rooms, every include goes downwards")
    return 1 if wrong else 0


sys.exit(main())

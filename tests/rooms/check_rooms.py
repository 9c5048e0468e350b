#!/usr/bin/env python3
"""Checks that folders include each other in one direction only, and that each class and function is where one looks for it.

The CMakeLists.txt of core/, protocol/, server/, client/, gateway/ and sim/ list their rooms from the ground up, each with the rooms
that it USES. A room may include headers of itself and of those; it may use only rooms that are listed before it, so that
no circle can be; and the client uses nothing of the server. Programs that users run link nothing of sim/, which has the laboratory.

A class has its member functions in its header and in one .cpp. A nested class counts as a part of its outer class if the same header
declares both; classes in anonymous namespaces of different files are different classes. What a header declares is defined in the
header's folder. No two headers have the same name.

--large-classes lists the classes with more than 20 data members instead. It never fails.

usage: check_rooms.py SOURCE_FOLDER [--large-classes]
"""

import collections
import pathlib
import re
import sys

sys.dont_write_bytecode = True  # no files beside the sources
from cpp_outline import Outline  # noqa: E402

FLOORS = ("core", "protocol", "server", "client", "gateway", "sim")  # from the ground up, as CMakeLists.txt adds them
FORBIDDEN = {("client", "server")}
MOST_MEMBERS = 20


def declared(source):
    """Room -> rooms that it uses, in the order of declaration."""
    rooms = {}
    for floor in FLOORS:
        text = (source / floor / "CMakeLists.txt").read_text(encoding="utf-8")
        for name, body in re.findall(r"^feltwire_room\(([^\s)]+)([^)]*)\)", text, re.M):
            uses = re.search(r"\bUSES((?:\s+[\w/]+)*?)(?=\s+(?:LINKS|PRIVATE|SOURCES|SCHEMAS)\b|\s*$)", body)
            rooms[f"{floor}/{name}"] = uses.group(1).split() if uses else []
    return rooms


def read_files(source):
    """File -> its text, of every header and .cpp of the product."""
    return {file.relative_to(source): file.read_text(encoding="utf-8")
            for floor in FLOORS for file in sorted((source / floor).rglob("*.[ch]pp"))}


def included(files):
    """(file, line, included file) of every include of our own headers."""
    for file, text in files.items():
        for number, line in enumerate(text.split("\n"), 1):
            found = re.match(r'#include "((?:%s)/[^"]+)"' % "|".join(FLOORS), line)
            if found:
                yield file, number, pathlib.PurePath(found.group(1))


def broken_includes(source, rooms, files):
    wrong = []
    for place, (room, uses) in enumerate(rooms.items()):
        below = list(rooms)[:place]
        wrong += [f"{room}: uses {used}, which is not listed before it" for used in uses if used not in below]
        wrong += [f"{room}: may not use {used}" for used in uses
                  if (room.split("/")[0], used.split("/")[0]) in FORBIDDEN]
    wrong += [f"{floor}/CMakeLists.txt: links {name}, which is of the laboratory; move what users run out of sim/"
              for floor in FLOORS[:-1]
              for name in re.findall(r"\bfeltwire_sim\w*", (source / floor / "CMakeLists.txt").read_text(encoding="utf-8"))]
    seen = {room: set() for room in rooms}
    for file, number, header in included(files):
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
    return wrong


def same_names(files):
    headers = collections.defaultdict(list)
    for file in files:
        if file.suffix == ".hpp":
            headers[file.name].append(str(file))
    return [f"{name}: is the name of {' and '.join(found)}; rename all but one"
            for name, found in headers.items() if len(found) > 1]


class Code:
    """The classes and functions of all files."""

    def __init__(self, files):
        self.outlines = {file: Outline(text) for file, text in files.items()}
        self._own = {file: {made.path for made in outline.classes} for file, outline in self.outlines.items()}
        self._header_of = {made.path: file for file, outline in self.outlines.items() if file.suffix == ".hpp"
                           for made in outline.classes if not made.local}

    def class_of(self, file, function):
        """(the file that declares it, its path) of the class of a function that is defined outside of it; None: it has no class."""
        for outer in range(len(function.scope), -1, -1):
            path = function.scope[:outer] + function.names[:-1]
            if path in self._own[file]:
                return file, path
            if path in self._header_of:
                return self._header_of[path], path
        return None

    def outermost(self, file, path):
        """The class around a nested class, if the same file declares it; else the class itself."""
        while path[:-1] in self._own[file]:
            path = path[:-1]
        return file, path

    def functions(self):
        """(file, function, its class or None as class_of()) of all functions."""
        for file, outline in self.outlines.items():
            for function in outline.functions:
                outside = len(function.names) > 1 and not function.in_class
                yield file, function, self.class_of(file, function) if outside else None


def scattered_classes(code):
    places = collections.defaultdict(set)
    for file, function, of_class in code.functions():
        if of_class is not None and function.defined and file.suffix == ".cpp":
            places[code.outermost(*of_class)].add(str(file))
    return [f"{'::'.join(path)} ({header}): its member functions are in {', '.join(sorted(files))}; a class that one .cpp cannot "
            "hold is two classes" for (header, path), files in sorted(places.items()) if len(files) > 1]


def distant_definitions(code):
    """Overloads with the same number of parameters count as the same function."""
    def key(function, of_class):
        path = of_class[1] + function.names[-1:] if of_class else function.scope + function.names
        return path, function.parameters

    places = collections.defaultdict(set)
    for file, function, of_class in code.functions():
        if function.defined and not function.local:
            places[key(function, of_class)].add(file)
    wrong = {}  # in the order of the files, each once
    for file, function, of_class in code.functions():
        if file.suffix != ".hpp" or function.defined or function.local:
            continue
        found = places[key(function, of_class)]  # empty: generated code has it
        if found and all(place.parent != file.parent for place in found):
            wrong[f"{file}: declares {'::'.join(key(function, of_class)[0])}, which {', '.join(map(str, sorted(found)))} defines; "
                  "declare it in that folder"] = None
    return list(wrong)


def large_classes(code):
    found = [(len(made.members), "::".join(made.path), str(file))
             for file, outline in code.outlines.items() for made in outline.classes]
    return [f"{members} {name} ({file})" for members, name, file in sorted(found, reverse=True) if members > MOST_MEMBERS]


def main():
    source = pathlib.Path(sys.argv[1])
    files = read_files(source)
    code = Code(files)
    if sys.argv[2:] == ["--large-classes"]:
        print("\n".join(large_classes(code)))
        return 0
    rooms = declared(source)
    wrong = broken_includes(source, rooms, files) + same_names(files) + scattered_classes(code) + distant_definitions(code)
    print("\n".join(wrong) or f"{len(rooms)} rooms, every include goes downwards, and every class is in one .cpp")
    return 1 if wrong else 0


sys.exit(main())

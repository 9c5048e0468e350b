"""The tests that judge a mutant of scripts/mutants: the programs of its room, and the test files that are nearest to its file.

It reads the CMakeLists.txt below tests/, and the includes of the sources.
"""
import collections
import os
import pathlib
import re

home = pathlib.Path(__file__).resolve().parent.parent
# The programs that judge a room, the cheapest first, each with the folders below tests/ whose tests it runs. Other rooms are judged by all
# programs that have tests of theirs, without those in real time.
JUDGES = {
    'core/bounding': (('property_test', ('core/bounding',)), ('core_test', ('core/bounding', 'core/safety', 'core/teleoperation'))),
    'protocol/wire': (('protocol_test', ('protocol',)),),
    'client/servo': (('client_test', ('client/servo', 'client/transport')), ('device_test', ('client/servo',)))}
# Tests of a room that another room's program has: they run only where they are nearest.
ELSEWHERE = {
    'client/servo': dict.fromkeys(('tests/client/simulated_robots/remote_hand_test.cpp', 'tests/client/simulated_robots/teleoperation_walls_test.cpp'),
                                  'teleoperation_session_test')}
NEAREST = 2          # test files that run before the programs


def expanded(words, lists):
    for word in words:
        name = re.fullmatch(r'\$\{(\w+)\}', word)
        yield from lists.get(name[1], [word]) if name else [word]


def programs():
    """The test programs by name: their sources, the libraries that are not rooms, whether they run in real time, their folder."""
    found = {}
    for path in sorted((home / 'tests').rglob('CMakeLists.txt')):
        text = re.sub(r'#.*', '', path.read_text())
        lists = {name: words.split() for name, words in re.findall(r'\bset\((\w+)\s+([^)]*)\)', text)}
        for body in re.findall(r'^feltwire_test\(([^()]*)\)', text, re.M):
            name, *words = body.split()
            part, parts = None, collections.defaultdict(list)
            for word in expanded(words, lists):
                if re.fullmatch(r'[A-Z_]{4,}', word):
                    part = word
                parts[part].append(word)
            sources = [os.path.normpath(os.path.relpath(path.parent / word, home)) for word in parts['SOURCES'][1:] if '$' not in word]
            others = [word for word in parts['LIBRARIES'][1:] if not word.startswith('feltwire_')]
            found[name] = (sources, others, 'REAL_TIME' in parts, str(path.parent.relative_to(home)))
    return found


def judges(room):
    if room in JUDGES:
        return JUDGES[room]
    return tuple((name, (room,)) for name, (sources, _, real_time, _) in PROGRAMS.items()
                 if not real_time and any(os.path.dirname(source) == f'tests/{room}' for source in sources))


def is_test(path):
    return path.endswith('_test.cpp')


def tests_in(program, folders):
    below = tuple(f'tests/{folder}/' for folder in folders)
    return [source for source in PROGRAMS[program][0] if is_test(source) and source.startswith(below)]


def tests_of(room):
    """The test files of a room's judges, each with its program."""
    return {**{source: program for program, folders in judges(room) for source in tests_in(program, folders)}, **ELSEWHERE.get(room, {})}


def suites(path):
    return set(re.findall(r'^(?:TEST|TEST_F|TEST_P|RC_GTEST_PROP|RC_GTEST_FIXTURE_PROP)\(\s*(\w+)', (home / path).read_text(), re.M))


def test_filter(program, folders):
    names = set().union(*map(suites, tests_in(program, folders)))
    return ':'.join(f'{name}.*:*/{name}.*' for name in sorted(names))


def includes(path):
    """The names that a file includes; none for a file that is not there, as a generated one."""
    if path not in INCLUDES:
        text = (home / path).read_text() if (home / path).is_file() else ''
        INCLUDES[path] = re.findall(r'^#include ["<]([^">]+)[">]', text, re.M)
    return INCLUDES[path]


def closure(path):
    seen, left = set(), [path]
    while left:
        left += [name for name in includes(left.pop()) if name not in seen and not seen.add(name)]
    return seen


def nearest(path):
    """The test files that are nearest to a source: those of its room that include its header, and have the most similar names."""
    room = os.path.dirname(path)
    header = path[:-4] + '.hpp'
    if not (home / header).is_file():
        header = next((name for name in includes(path) if os.path.dirname(name) == room), path)
    words = set(pathlib.Path(path).stem.split('_')) | set(pathlib.Path(header).stem.split('_'))

    def farness(test):
        name = pathlib.Path(test).stem.split('_')[:-1]
        return (-len(words & set(name)), os.path.dirname(test) != f'tests/{room}', header not in includes(test), len(name), test)

    possible = [test for test in tests_of(room) if alone_possible(test)]
    seen = [test for test in possible if header in closure(test)]
    named = [test for test in possible if words & set(pathlib.Path(test).stem.split('_')[:-1])]  # for a header that only sources include
    return sorted(seen or named, key=farness)[:NEAREST]


def alone_possible(test):
    return not re.search(r'\bFELTWIRE_(?!SOURCE_DIR|SANITIZED)[A-Z_]+\b', (home / test).read_text())


def target_of(test):
    return 'near_' + re.sub(r'\W', '_', test.removeprefix('tests/').removesuffix('.cpp'))


PROGRAMS, INCLUDES = programs(), {}

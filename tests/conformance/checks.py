"""The list of checks, and how one is judged. A check is a function that raises Failure, or returns what it saw."""
import time
import traceback

import patience

REGISTRY = {"server": [], "client": []}


TIMED_OUT = "it did not happen within"


class Failure(Exception):
    """The other end did not do what the sentence says; the text says what was seen."""


class Check:
    def __init__(self, identity, sentence, function, needs):
        self.identity, self.sentence, self.function, self.needs = identity, " ".join(sentence.split()), function, needs


def check(identity, sentence, needs=""):
    """Adds a check. `needs`: empty, or a property of the subject without which the check cannot be made."""
    side = "server" if identity.startswith("S") else "client"

    def add(function):
        if any(other.identity == identity for other in REGISTRY[side]):
            raise ValueError(f"{identity} is there twice")
        REGISTRY[side].append(Check(identity, sentence, function, needs))
        return function
    return add


def expect(condition, seen):
    if not condition:
        raise Failure(seen)


def eventually(condition, what, seconds=None):
    """Waits for a condition; its value."""
    seconds = patience.LONGEST if seconds is None else seconds
    end = time.monotonic() + seconds
    while True:
        value = condition()
        if value:
            return value
        if time.monotonic() > end:
            raise Failure(f"{TIMED_OUT} {seconds} s: {what}")
        time.sleep(0.002)


def judge(one, subject):
    """(passed, what was seen) of one check."""
    try:
        return True, one.function(subject) or "as the text says"
    except Failure as failure:
        return False, str(failure)
    except Exception as error:  # a closed connection, a table that cannot be read: the check saw something else than it expected
        place = traceback.extract_tb(error.__traceback__)[-1]
        return False, f"{type(error).__name__}: {error} ({place.name}, line {place.lineno})"


def judge_program(one, subject):
    """judge(), and up to twice again where it fails: a machine that stood still may have broken a check, and a program that deviates
    fails every time."""
    for _ in range(2):
        passed, seen = judge(one, subject)
        if passed:
            return passed, seen
        print(f"{one.identity} failed, and is judged again: {seen}", flush=True)
    return judge(one, subject)


def run(side, subject, wanted):
    """Judges the checks of a side, or those wanted, by rising number, and prints them. Returns the exit status."""
    failed = 0
    for one in sorted(REGISTRY[side], key=lambda one: one.identity):
        if not wanted or one.identity in wanted:
            passed, seen = judge_program(one, subject)
            report(one, passed, seen)
            failed += not passed
    print(f"{failed} checks failed" if failed else "all checks passed")
    return 1 if failed else 0


def list_checks(side):
    for one in REGISTRY[side]:
        print(f"{one.identity}  {one.sentence}")


def report(one, passed, seen):
    print(f"{one.identity} {'passed' if passed else 'FAILED'}: {seen}", flush=True)
    if not passed:
        print(f"     the text: {one.sentence}", flush=True)

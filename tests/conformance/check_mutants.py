#!/usr/bin/env python3
"""Checks the checks: each deviation of a model (mutants.py) must be found by the check that it names, and the models themselves must pass.

usage: check_mutants.py [NAME ...]
"""
import sys
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
import checks  # noqa: E402
import every_check  # noqa: E402,F401
import mutants  # noqa: E402
import patience  # noqa: E402
from client_process import Client  # noqa: E402
from model_server import ModelServer  # noqa: E402

LITTLE_PATIENCE = 3.0  # [s]
MODELS_AT_ONCE = 4
MUTANTS_AT_ONCE = {"server": 12, "client": 6}  # most of their time is waiting


def judged_server(wrong, one):
    server = ModelServer([wrong] if wrong else ())
    try:
        return checks.judge(one, server)
    finally:
        server.close()


def judged_client(wrong, one):
    client = Client(wrong=wrong)
    try:
        return checks.judge(one, client)
    finally:
        client.close()


def check_models(side, judged, deviations, wanted):
    """The number of checks that fail with the model, and of deviations that are not found."""
    known, failed = {one.identity: one for one in checks.REGISTRY[side] if not one.needs or one.needs in ModelServer.has}, 0
    if not wanted:
        with ThreadPoolExecutor(MODELS_AT_ONCE) as pool:
            results = list(pool.map(lambda one: judged(None, one), known.values()))
        for one, (passed, seen) in zip(known.values(), results):
            if not passed:
                passed, seen = judged(None, one)
            if not passed:
                print(f"FAILED: the model {side}, {one.identity}: {seen}")
                failed += 1
    names = [name for name in deviations if not wanted or name in wanted]
    patience.LONGEST, usual = LITTLE_PATIENCE, patience.LONGEST
    with ThreadPoolExecutor(MUTANTS_AT_ONCE[side]) as pool:
        results = list(pool.map(lambda name: judged(name, known[deviations[name][1]]), names))
    patience.LONGEST = usual
    # A deviation that was not found is tried again alone: a machine that stood still hides it. Something that did not come proves nothing
    # where it should have come.
    for place, name in enumerate(names):
        for left in (2, 1, 0):
            passed, seen = results[place]
            late = not passed and seen.startswith(checks.TIMED_OUT) and name not in mutants.ABSENT
            if not passed and not late:
                break
            results[place] = judged(name, known[deviations[name][1]]) if left else (True, seen)
    for name, (passed, seen) in zip(names, results):
        what, identity = deviations[name]
        seen = " ".join(seen.split())[:150]
        print(f"{'FAILED, not found' if passed else 'found'} by {identity}: a {side} that {what}" + ("" if passed else f" ({seen})"))
        failed += passed
    unused = set(known) - {identity for _, identity in deviations.values()}
    if not wanted:
        print(f"{len(names)} deviations of a {side}; no deviation for {' '.join(sorted(unused)) or 'none of the checks'}")
    return failed


def main(wanted):
    failed = check_models("server", judged_server, mutants.SERVERS, wanted) + check_models("client", judged_client, mutants.CLIENTS, wanted)
    print(f"{failed} failed" if failed else "all deviations were found")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

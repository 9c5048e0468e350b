#!/usr/bin/env python3
"""Checks the checks: each deviation of a model (mutants.py) must be found by the check that it names, and the models themselves must pass.

usage: check_mutants.py [NAME ...]
"""
import sys
from concurrent.futures import ThreadPoolExecutor

sys.dont_write_bytecode = True
import checks  # noqa: E402
import checks_admin  # noqa: E402,F401
import checks_control  # noqa: E402,F401
import checks_datagram  # noqa: E402,F401
import checks_roles  # noqa: E402,F401
import checks_session  # noqa: E402,F401
import mutants  # noqa: E402
import patience  # noqa: E402
from model_server import ModelServer  # noqa: E402

WITHOUT_PATIENCE = 1.5  # [s]
AT_ONCE = 8  # mutants; most of their time is waiting


def judged(wrong, one):
    server = ModelServer(wrong)
    try:
        return checks.judge(one, server)
    finally:
        server.close()


def check_servers(wanted):
    failed = 0
    known = {one.identity: one for one in checks.REGISTRY["server"]}
    for one in sorted(known.values(), key=lambda one: one.identity):
        if not one.needs and not wanted:
            passed, seen = judged((), one)
            if not passed:
                print(f"FAILED: the model server, {one.identity}: {seen}")
                failed += 1
    patience.LONGEST, usual = WITHOUT_PATIENCE, patience.LONGEST
    names = [name for name in mutants.SERVERS if not wanted or name in wanted]
    with ThreadPoolExecutor(AT_ONCE) as pool:
        results = list(pool.map(lambda name: judged({name}, known[mutants.SERVERS[name][1]]), names))
    for name, (passed, seen) in zip(names, results):
        what, identity = mutants.SERVERS[name]
        print(f"{'FAILED, not found' if passed else 'found'} by {identity}: a server that {what}" + ("" if passed else f" ({seen[:150]})"))
        failed += passed
    patience.LONGEST = usual
    return failed


def main(wanted):
    failed = check_servers(wanted)
    print(f"{failed} failed" if failed else "all deviations were found")
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))

#!/usr/bin/env python3
"""The composed tests: python3 tests/docker/run.py FOLDER [NAME ...]; scripts/test-docker builds the image first.

Each test is a file of its own with run(compose, judge), in the order of NAMES.
"""

import importlib
import pathlib
import shutil
import subprocess
import sys
import time
import traceback

import composition
from composition import Composition
from judge import Judge
from plot import plot

NAMES = ["shipped", "clean_link", "many_devices", "bad_link", "interruptions", "server_killed", "garbage",
         "rolling_restart", "robot", "fleet"]


def missing():
    """What stands in the way of running containers; None when nothing does."""
    if shutil.which("docker") is None:
        return "there is no docker program (apt-get install docker.io docker-compose)"
    if composition.compose_program() is None:
        return "there is no Docker Compose (apt-get install docker-compose)"
    try:
        told = subprocess.run(["docker", "info"], capture_output=True, text=True, timeout=20)
    except subprocess.TimeoutExpired:
        return "the Docker engine does not answer"
    return None if told.returncode == 0 else "no Docker engine answers"


def run(name, folder):
    """One test: what is wrong, as lines; empty when it passed."""
    shutil.rmtree(folder, ignore_errors=True)
    folder.mkdir(parents=True)
    judge, compose = Judge(), Composition(name, folder)
    try:
        importlib.import_module(f"cases.{name}").run(compose, judge)
        for recording in sorted(compose.out.glob("*.csv")):
            plot(recording, f"{name}: {recording.stem}")
    except Exception as error:  # whatever it was, the others still run
        judge.failures.append(f"FAIL {error}")
        judge.lines.append(traceback.format_exc())
    finally:
        try:
            compose.end()
        except Exception as error:
            judge.failures.append(f"FAIL at the end: {error}")
    (folder / "checks.txt").write_text("\n".join([*judge.lines, *judge.failures]) + "\n")
    return judge.failures


def passes(name, folder):
    begin = time.monotonic()
    failures = run(name, folder)
    print(f"docker {name}: {'FAILED' if failures else 'passed'}, {time.monotonic() - begin:.0f} s", flush=True)
    for line in failures:
        print(f"  {line}")
    if failures:
        print(f"  look into {folder}", flush=True)
    return not failures


def main():
    folder, wanted = pathlib.Path(sys.argv[1]).resolve(), sys.argv[2:] or NAMES
    unknown = [name for name in wanted if name not in NAMES]
    if unknown:
        sys.exit(f"no composed test is named {', '.join(unknown)}; there are {', '.join(NAMES)}")
    why = missing()
    if why:
        for name in wanted:
            print(f"docker {name}: SKIPPED, {why}")
        return 0
    failed = [name for name in wanted if not passes(name, folder / name)]
    # A second run tells what fails always from what fails now and then. Neither is a pass.
    for name in failed:
        again = passes(name, folder / f"{name}-again")
        print(f"docker {name}: counts as FAILED; {'a second run passed, so it fails now and then' if again else 'twice'}")
    if failed:
        print(f"docker: {len(failed)} of {len(wanted)} tests failed: {', '.join(failed)}", flush=True)
    return 1 if failed else 0


if __name__ == "__main__":
    sys.exit(main())

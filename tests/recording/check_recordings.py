#!/usr/bin/env python3
"""Lets another implementation of MCAP read every file that the tests of recordings write.

The other one is @mcap/core of npm, in the versions of package-lock.json. Exit status 77: skipped, because there is no npm
or no registry that answers.

usage: check_recordings.py BUILD_FOLDER TEST_PROGRAM ...
"""

import os
import pathlib
import shutil
import subprocess
import sys

SKIPPED = 77
FILTER = ("Mcap.*:McapRecording.*:Replay*:RecordingForExport.*:FlightRecorderTest.*:"
          "FlightRecordTest.*-FlightRecordTest.OldestFilesAreRemovedWhereTheyAreLarge:FlightRecorderTest.OldestFiles*")
# A recording of each kind of program: a missing kind is an error.
KINDS = ("ticks.mcap", "server-TwoHandsAndABody.mcap", "server-EvictionIsWrittenWithTheLastTenSeconds.mcap",
         "client-HasTheLastTenSecondsInTheirOrder.mcap")


def install(source, to):
    """Has the packages in `to`. Returns why not, or nothing."""
    if not shutil.which("npm") or not shutil.which("node"):
        return "npm is not installed; install nodejs and npm to check recordings with @mcap/core"
    lock = (source / "package-lock.json").read_bytes()
    done = to / "installed-lock.json"
    if done.exists() and done.read_bytes() == lock:
        return None
    for name in ("package.json", "package-lock.json"):
        shutil.copy(source / name, to / name)
    ran = subprocess.run(["npm", "ci", "--ignore-scripts", "--no-audit", "--no-fund"], cwd=to, text=True,
                         capture_output=True, timeout=240)
    if ran.returncode != 0:
        return f"npm ci failed; is the registry reachable?\n{ran.stderr}"
    done.write_bytes(lock)
    return None


def main():
    source = pathlib.Path(__file__).resolve().parent
    to = pathlib.Path(sys.argv[1]).resolve() / "tests/recording/npm"
    to.mkdir(parents=True, exist_ok=True)
    why_not = install(source, to)
    if why_not:
        print(f"skipped: {why_not}")
        return SKIPPED

    files = to / "files"
    shutil.rmtree(files, ignore_errors=True)
    files.mkdir()
    for program in sys.argv[2:]:
        subprocess.run([program, f"--gtest_filter={FILTER}", "--gtest_brief=1"], check=True,
                       env={**os.environ, "FELTWIRE_KEEP_RECORDINGS": str(files)})
    shutil.copy(source / "read.mjs", to / "read.mjs")
    written = sorted(str(file) for file in files.glob("*.mcap"))
    missing = [kind for kind in KINDS if not (files / kind).exists()]
    if missing:
        print(f"the tests kept no {', '.join(missing)}")
        return 1
    return subprocess.run(["node", "read.mjs", *written], cwd=to).returncode


sys.exit(main())

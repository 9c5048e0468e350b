#!/usr/bin/env python3
"""scripts/demo --stay: hands and page stay until Ctrl-C, which ends everything that the script has started.

The script runs in a folder with the programs that are built already. Its commands that install and build do nothing there.

usage: check_demo.py BIN_FOLDER SOURCE_FOLDER
"""

import contextlib
import os
import pathlib
import re
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import unittest
import urllib.request

PROGRAMS, SOURCE = (pathlib.Path(word).resolve() for word in sys.argv[1:3])
PATIENCE = 120  # [s]


def until(what, condition):
    deadline = time.monotonic() + PATIENCE
    while not (value := condition()):
        if time.monotonic() > deadline:
            raise AssertionError(f"in vain: {what}")
        time.sleep(0.05)
    return value


def in_session(leader):
    """The commands of all processes in the session of a leader"""
    found = []
    for folder in pathlib.Path("/proc").glob("[0-9]*"):
        with contextlib.suppress(OSError):
            state, _, _, session = (folder / "stat").read_text().rpartition(")")[2].split()[:4]
            if int(session) == leader and state != "Z":
                found.append((folder / "cmdline").read_bytes().replace(b"\0", b" ").decode())
    return found


class Stay(unittest.TestCase):
    def setUp(self):
        self.folder = pathlib.Path(self.enterContext(tempfile.TemporaryDirectory()))
        (self.folder / "scripts").mkdir()
        shutil.copy(SOURCE / "scripts/demo", self.folder / "scripts/demo")
        (self.folder / "scenes").symlink_to(SOURCE / "scenes")
        (self.folder / "build/release").mkdir(parents=True)
        (self.folder / "build/release/bin").symlink_to(PROGRAMS)
        (self.folder / "commands").mkdir()
        for nothing in ("scripts/install-packages", "commands/cmake"):
            (self.folder / nothing).write_text("#!/bin/sh\n")
            (self.folder / nothing).chmod(0o755)

    def start(self):
        """The script, and the address of its page when it says that it stays"""
        environment = {**os.environ, "PATH": f"{self.folder}/commands:{os.environ['PATH']}"}
        demo = self.enterContext(subprocess.Popen([self.folder / "scripts/demo", "--stay", self.folder / "out"], stdout=subprocess.PIPE,
                                                  stderr=subprocess.STDOUT, text=True, env=environment, start_new_session=True))
        self.addCleanup(self.end, demo)
        said = ""
        for line in demo.stdout:
            said += line
            if line == "Hands and page stay until Ctrl-C.\n":
                return demo, re.search(r"See the hands: +(http://127\.0\.0\.1:\d+/)#token=fw_", said)[1]
        raise AssertionError(said)

    @staticmethod
    def end(demo):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(demo.pid, signal.SIGKILL)

    def hands(self, page):
        with urllib.request.urlopen(page + "metrics", timeout=PATIENCE) as answer:
            return int(re.search(r'feltwire_sessions\{scene="room"\} (\d+)', answer.read().decode())[1])

    def ends(self, send):
        demo, page = self.start()
        until("two hands", lambda: self.hands(page) == 2)
        with urllib.request.urlopen(page, timeout=PATIENCE) as answer:
            self.assertEqual(answer.status, 200)
        self.assertGreaterEqual(len(in_session(demo.pid)), 4)
        send(demo)
        said, _ = demo.communicate(timeout=PATIENCE)
        self.assertEqual(demo.returncode, 0, said)
        self.assertEqual(in_session(demo.pid), [])

    def test_ctrl_c_ends_everything(self):
        # A terminal sends the signal to the script and to all that it has started.
        self.ends(lambda demo: os.killpg(demo.pid, signal.SIGINT))

    def test_a_signal_to_the_script_ends_everything(self):
        self.ends(lambda demo: os.kill(demo.pid, signal.SIGTERM))

    def test_a_hand_that_ends_is_told(self):
        demo, page = self.start()
        until("two hands", lambda: self.hands(page) == 2)
        for folder in pathlib.Path("/proc").glob("[0-9]*"):
            with contextlib.suppress(OSError):
                if f"{self.folder}/out/left-hand.json".encode() in (folder / "cmdline").read_bytes():
                    os.kill(int(folder.name), signal.SIGKILL)
        said, _ = demo.communicate(timeout=PATIENCE)
        self.assertEqual(demo.returncode, 1, said)
        self.assertIn("has ended by itself", said)
        self.assertEqual(in_session(demo.pid), [])


if __name__ == "__main__":
    unittest.main(argv=sys.argv[:1])

#!/usr/bin/env python3
"""Every block of Python in docs/python.md runs, in the page's order, as one program; so do the blocks of C in docs/c_api.md."""
import os
import pathlib
import re
import subprocess
import tempfile
import unittest

from support import PATIENTLY, SOURCE, numpy, run_python
import feltwire

try:
    import matplotlib
except ImportError:
    matplotlib = None

PAGE = SOURCE / "docs/python.md"
C_PAGE = SOURCE / "docs/c_api.md"

# torch, Isaac Lab and Gymnasium are not installed here.
STANDING_IN = f"import sys; sys.path.append({str(SOURCE / 'tests/python')!r}); import stand_ins; stand_ins.put(stand_ins.isaac(), stand_ins.gymnasium())"

# A program of the blocks of C, which takes the address of a server, its fingerprint's file, and the files of the tokens of a hand and an admin.
IN_C = """
#define _POSIX_C_SOURCE 199309L
#include <feltwire.h>
#include <stdio.h>
#include <time.h>

static int failed(void) { return puts(fw_last_error()), 1; }

int main(int argc, char** argv) {
  if (argc != 5) return 2;
  fw_hand_options options;
  fw_hand_options_default(&options, sizeof options);
  options.server = argv[1];
  options.fingerprint_file = argv[2];
  options.token_file = argv[3];
  options.scene = "bench";
  options.duration = 1.0;
  %s
  fw_hand* hand;
  if (fw_hand_open(&options, &hand) != FW_OK) return failed();
  %s
  if (fw_hand_wait(hand, 20.0) != FW_ENDED) return puts("the run did not end"), 1;
  if (fw_recorder_close(recorder) != FW_OK) return failed();
  fw_hand_close(hand); /* a busy machine may have let the hand go */
  fw_admin_options of_admin;
  fw_admin_options_default(&of_admin, sizeof of_admin);
  of_admin.server = argv[1];
  of_admin.fingerprint_file = argv[2];
  of_admin.token_file = argv[4];
  fw_admin* admin;
  if (fw_admin_open(&of_admin, &admin) != FW_OK) return failed();
  %s
  else return failed();
  return fw_admin_close(admin) == FW_OK ? 0 : failed();
}
"""


class Page(unittest.TestCase):
    @unittest.skipUnless(numpy and matplotlib, "NumPy or matplotlib is not installed")
    def test_the_blocks_run(self):
        blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
        self.assertGreater(len(blocks), 5)
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "scenes").symlink_to(SOURCE / "scenes")
            said = run_python("\n".join([PATIENTLY, STANDING_IN, *blocks]), folder=folder)
            written = {path.name for path in folder.iterdir()} - {"scenes"}
        self.assertEqual(written, {"hand.png", "hand.mcap", "taps.png", "kitchen.json", "episode.mcap"})
        self.assertGreater(float(re.search(r"the plane pushed with at most (\S+) N", said)[1]), 0.3)
        for simulator in ("Isaac Lab", "Gymnasium"):
            self.assertGreater(float(re.search(rf"{simulator}: (\S+) N", said)[1]), 0.1)
        for words in ("simulated ['/hand/account'", "ticks with force: ", "scene kitchen: 2 objects", "['kitchen']", "kitchen.json:8: objects[1].sphere.radius",
                      "1.2", "Run all methods at the limits"):
            self.assertIn(words, said)

    def test_the_first_block_is_short(self):
        first = re.search(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[1]
        self.assertLessEqual(len(first.splitlines()), 10)

    def test_the_page_names_what_the_package_has(self):
        """Every feltwire.NAME of the page is one."""
        for name in set(re.findall(r"(?<!lib)feltwire\.([a-zA-Z_]\w*)", PAGE.read_text(encoding="utf-8"))):
            self.assertTrue(hasattr(feltwire, name), name)


class CPage(unittest.TestCase):
    def test_the_blocks_run_as_the_page_builds_them(self):
        page = C_PAGE.read_text(encoding="utf-8")
        blocks = re.findall(r"^```c\n(.*?)^```", page, re.DOTALL | re.MULTILINE)
        self.assertEqual(len(blocks), 3)
        build = re.search(r"^    (cc .* my_hand\.c .*)$", page, re.MULTILINE)[1]
        library = pathlib.Path(os.environ["FELTWIRE_LIBRARY"]).parent
        scene = feltwire.Scene("bench")
        scene.material("wood", 800)
        scene.plane("table", material="wood")
        with tempfile.TemporaryDirectory() as name, feltwire.serve(scene) as server:
            folder = pathlib.Path(name)
            (folder / "my_hand.c").write_text(IN_C % tuple(blocks), encoding="utf-8")
            there = {**os.environ, "CPATH": str(SOURCE / "client/c_api"), "LIBRARY_PATH": str(library), "LD_LIBRARY_PATH": str(library)}
            subprocess.run(build.split(), cwd=folder, env=there, check=True)
            done = subprocess.run(["./a.out", server.address, server.fingerprint_file, server.token_file, server._token("admin", "*")], cwd=folder,
                                  env=there, capture_output=True, text=True, check=False)
            self.assertEqual(done.returncode, 0, done.stdout + done.stderr)
            self.assertIn("{", done.stdout)
            with server.admin() as admin:
                self.assertEqual(admin.scenes()[0]["scene"], "bench")
            for file in ("session.mcap", "episode-1.mcap"):
                self.assertGreater(len(feltwire.read(folder / file)["/hand/sample"]), 10, file)


if __name__ == "__main__":
    unittest.main()

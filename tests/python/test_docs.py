#!/usr/bin/env python3
"""Every block of Python in docs/python.md runs, in the page's order, as one program."""
import pathlib
import re
import tempfile
import unittest

from support import PATIENTLY, SOURCE, numpy, run_python

try:
    import matplotlib
except ImportError:
    matplotlib = None

PAGE = SOURCE / "docs/python.md"


class Page(unittest.TestCase):
    @unittest.skipUnless(numpy and matplotlib, "NumPy or matplotlib is not installed")
    def test_the_blocks_run(self):
        blocks = re.findall(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)
        self.assertGreater(len(blocks), 5)
        with tempfile.TemporaryDirectory() as name:
            folder = pathlib.Path(name)
            (folder / "scenes").symlink_to(SOURCE / "scenes")
            said = run_python("\n".join([PATIENTLY, *blocks]), folder=folder)
            written = {path.name for path in folder.iterdir()} - {"scenes"}
        self.assertEqual(written, {"hand.png", "hand.mcap", "taps.png", "kitchen.json", "episode.mcap"})
        self.assertGreater(float(re.search(r"the plane pushed with at most (\S+) N", said)[1]), 0.3)
        for words in ("simulated ['/hand/account'", "ticks with force: ", "scene kitchen: 2 objects", "['kitchen']", "kitchen.json:8: objects[1].sphere.radius",
                      "1.2", "Run all methods at the limits"):
            self.assertIn(words, said)

    def test_the_first_block_is_short(self):
        first = re.search(r"^```python\n(.*?)^```", PAGE.read_text(encoding="utf-8"), re.DOTALL | re.MULTILINE)[1]
        self.assertLessEqual(len(first.splitlines()), 10)

    def test_the_page_names_what_the_package_has(self):
        """Every feltwire.NAME of the page is one."""
        import feltwire
        for name in set(re.findall(r"(?<!lib)feltwire\.([a-zA-Z_]\w*)", PAGE.read_text(encoding="utf-8"))):
            self.assertTrue(hasattr(feltwire, name), name)


if __name__ == "__main__":
    unittest.main()

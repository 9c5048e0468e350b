#!/usr/bin/env python3
"""feltwire.plot(): the axis of the largest force, the curves and their units."""
import math
import os
import pathlib
import shutil
import tempfile
import types
import unittest

from support import WITHOUT_NUMPY, numpy, run_python
import feltwire
from feltwire.plots import largest_axis

try:
    import matplotlib
    matplotlib.use("agg")
except ImportError:
    matplotlib = None


def ticks(axis=2, count=500):
    """A tap: the hand goes 3 mm into a wall of 600 N/m."""
    found = []
    for i in range(count):
        depth = 0.003 * math.sin(2 * math.pi * i / count)
        position, force = [0.0, 0.0, 0.0], [0.0, 0.0, 0.0]
        position[axis], force[axis] = -depth, max(600 * depth, 0.0)
        found.append(types.SimpleNamespace(time=0.001 * i, position=position, force=force, balance=1e-3 + 1e-6 * i))
    return found


class Axis(unittest.TestCase):
    def test_the_axis_of_the_largest_force(self):
        for given, commanded, axis in (([[0, 0, 2]], [[0, 0, 2]], 2), ([[0, -3, 2]], None, 1), ([[1, 0, 0]], [[2.5, 0, 2.4]], 0),
                                       ([[-4, 0, 1]], [[0, 0, 1]], 0), ([[0, 0, 0]], None, 2), ([], [], 2), ([[2, 2, 2]], None, 2)):
            self.assertEqual(largest_axis(given, commanded), axis, (given, commanded))

    def test_without_matplotlib_and_gnuplot_the_error_says_what_to_install(self):
        for path, search in (("None", os.environ["PATH"]), ("'x.png'", "/none")):
            code = f"import feltwire\ntry:\n    feltwire.plot([], {path})\nexcept feltwire.Error as e:\n    print(e)"
            self.assertIn("install python3-matplotlib", run_python(WITHOUT_NUMPY + code, PATH=search))

    @unittest.skipUnless(shutil.which("gnuplot"), "gnuplot is not installed")
    def test_gnuplot_draws_without_matplotlib(self):
        code = WITHOUT_NUMPY + """
import types
import feltwire
tick = types.SimpleNamespace
ticks = [tick(time=0.001 * i, position=[0, 0, -1e-6 * i], force=[0, 0, 6e-4 * i], balance=1e-6 * i) for i in range(99)]
print(feltwire.plot(ticks, sys.argv[1]))
"""
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "a 'tap'.png"
            self.assertEqual(run_python(code, path).strip(), "None")
            self.assertEqual(path.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")


@unittest.skipUnless(matplotlib and numpy, "matplotlib is not installed")
class Pictures(unittest.TestCase):
    def test_ticks(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "tap.png"
            figure = feltwire.plot(ticks(1), path)
            self.assertEqual(path.read_bytes()[:8], b"\x89PNG\r\n\x1a\n")
        panels = figure.get_axes()
        self.assertEqual([panel.get_ylabel() for panel in panels], ["y of the hand [mm]", "force along y [N]", "balance of the account [mJ]"])
        self.assertEqual(panels[-1].get_xlabel(), "time [s]")
        self.assertAlmostEqual(max(panels[1].get_lines()[0].get_ydata()), 1.8, places=2)
        self.assertAlmostEqual(min(panels[0].get_lines()[0].get_ydata()), -3.0, places=2)
        self.assertEqual(feltwire.plot(ticks(1), axis="x").get_axes()[1].get_ylabel(), "force along x [N]")
        with self.assertRaisesRegex(ValueError, "'w' is not x, y or z"):
            feltwire.plot(ticks(), axis="w")
        with self.assertRaisesRegex(ValueError, "no ticks"):
            feltwire.plot([])

    def test_a_recording(self):
        with tempfile.TemporaryDirectory() as folder:
            path = pathlib.Path(folder) / "hand.csv"
            path.write_text("t,x,y,z,ex,ey,ez,fx,fy,fz,rx,ry,rz,age\n0,0,0,-0.001,0,0,1,0.5,0,0,0,0,0.75,0\n0.001,0,0,-0.001,0,0,1,0.5,0,0,0,0,0.75,0\n")
            panels = feltwire.plot(feltwire.read(path)).get_axes()
        self.assertEqual(len(panels), 2)
        self.assertEqual([list(line.get_ydata()) for line in panels[1].get_lines()], [[1, 1], [0.75, 0.75]])
        self.assertEqual([text.get_text() for text in panels[1].get_legend().get_texts()], ["commanded by the scene", "given to the hand"])


if __name__ == "__main__":
    unittest.main()

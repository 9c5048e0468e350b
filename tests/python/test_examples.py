#!/usr/bin/env python3
"""Every program of examples/python runs, and says what it should."""
import pathlib
import re
import tempfile
import unittest

from support import PATIENTLY, SOURCE, numpy, run_python
import feltwire

try:
    import matplotlib
except ImportError:
    matplotlib = None

FOLDER = SOURCE / "examples/python"


class Examples(unittest.TestCase):
    def setUp(self):
        self.temporary = tempfile.TemporaryDirectory()
        self.folder = pathlib.Path(self.temporary.name)

    def tearDown(self):
        self.temporary.cleanup()

    def run_example(self, name, *arguments):
        code = PATIENTLY + "import runpy, sys\nsys.argv = sys.argv[1:]\nrunpy.run_path(sys.argv[0], run_name='__main__')"
        return run_python(code, FOLDER / name, *arguments, folder=self.folder)

    @unittest.skipUnless(numpy, "NumPy is not installed")
    def test_recording_to_numpy(self):
        picture = self.folder / "hand.png"
        said = self.run_example("recording_to_numpy.py", *([picture] if matplotlib else []))
        self.assertIn("ticks of simulated in scene plane", said)
        self.assertIn("smallest balance", said)
        self.assertEqual(picture.exists(), bool(matplotlib))

    def test_scene_by_program(self):
        said = self.run_example("scene_by_program.py", self.folder / "bumps.json")
        self.assertIn("scene bumps: 26 objects", said)
        self.assertIn("1.20 N", said)  # 600 N/m, 2 mm deep in the middle of a ball
        self.assertEqual(feltwire.Scene.load(self.folder / "bumps.json").check().text.splitlines()[0], said.splitlines()[0])

    def test_two_hands(self):
        said = self.run_example("two_hands.py", "1.5")
        self.assertIn("largest forces: ", said)
        self.assertTrue({"press", "taps"} <= {line.split()[0] for line in said.splitlines() if line}, said)

    def test_program_as_device(self):
        self.assertIn("the mass rests ", self.run_example("program_as_device.py", "1"))

    def test_six_dof_device(self):
        said = self.run_example("six_dof_device.py", "2")
        tilt, torque = (float(one) for one in re.search(r"laid it down to (-?\d+); .* largest torque (\S+) mN m", said).groups())
        self.assertLess(tilt, 180.0, said)
        self.assertGreater(torque, 3.0, said)

    def test_follower_with_gripper(self):
        said = self.run_example("follower_with_gripper.py", "6")
        self.assertRegex(said, r"the robot is engaged, at z = -\d+.\d mm, and presses with [1-9]")
        self.assertRegex(said, r"open by 40 mm; the hand felt at most [1-9]|open by 40 mm; the hand felt at most 0.[1-9]")

    def test_lab_verb(self):
        said = {line.split()[0]: float(line.split()[-2]) for line in self.run_example("lab_verb.py").splitlines()}
        self.assertGreater(said["none"], 0.1)
        self.assertLessEqual(said["contact_frame"], 1e-6 + said["none"])

    def test_own_law(self):
        said = self.run_example("own_law.py")
        self.assertIn("no stress makes it break its promise", said)
        self.assertRegex(said, r"tap [^\0]*\n +contact_frame [^\0]*\n +energy_store ")
        with self.assertRaisesRegex(AssertionError, "FAILED  an ordinary hand, wrong_sign, double"):
            self.run_example("own_law.py", "--wrong-sign")

    def test_worlds(self):
        self.assertRegex(self.run_example("world_platform.py", "2"), "the platform pushed with at most [1-9]")
        self.assertRegex(self.run_example("world_tissue.py", "2"), "the tissue pushed with at most [1-9]")

    @unittest.skipUnless(numpy, "NumPy is not installed")
    def test_world_of_numpy(self):
        self.assertRegex(self.run_example("world_cloth.py", "2"), r"the cloth pushed with at most (0\.[1-9]|[1-9])")

    def test_they_are_short_and_all_are_run(self):
        names = {path.name for path in FOLDER.glob("*.py")}
        self.assertEqual(names, {"recording_to_numpy.py", "scene_by_program.py", "two_hands.py", "program_as_device.py", "lab_verb.py",
                                 "own_law.py", "follower_with_gripper.py", "six_dof_device.py",
                                 "world_cloth.py", "world_platform.py", "world_tissue.py"})
        # The observer, the admin (test_observer.py) and the hand in C (tests/install) are examples of the package too.
        for path in [*(FOLDER / name for name in names), *(FOLDER.parent / name for name in ("my_observer.py", "my_admin.py", "my_hand.c"))]:
            self.assertLess(len(path.read_text().splitlines()), 80, path)


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""A recording that a program starts and stops: what is in the file is what the program saw."""
import os
import pathlib
import tempfile
import unittest

from support import PATIENT, SOURCE, eventually, numpy
import feltwire


def column(ticks, field):
    return [list(row) if hasattr(row, "__len__") else row for row in (ticks[field] if numpy else [getattr(tick, field) for tick in ticks])]


class Recorders(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = feltwire.serve(SOURCE / "scenes/plane.json")

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def setUp(self):
        temporary = tempfile.TemporaryDirectory()
        self.addCleanup(temporary.cleanup)
        self.file = pathlib.Path(temporary.name) / "hand.mcap"

    @unittest.skipUnless(numpy, "NumPy is not installed")
    def test_the_file_has_the_ticks_that_the_program_saw(self):
        seen = []
        with self.server.join(device="simulated:path=press", **PATIENT) as hand:
            def ticks(least):
                seen.append(hand.ticks())
                return sum(map(len, seen)) >= least

            eventually("ticks before", lambda: ticks(50))
            with hand.record(self.file) as recorder:
                ticks(0)  # those before the recorder began, too
                before = sum(map(len, seen))
                eventually("force", lambda: ticks(before + 300) and seen[-1]["force"][-1][2] > 0.0 if len(seen[-1]) else ticks(0))
                recorder.mark("pressed")
                with self.assertRaisesRegex(ValueError, "character that UTF-8 does not have"):
                    recorder.mark(os.fsdecode(b"caf\xe9"))
                eventually("ticks", lambda: ticks(before + 600))
                self.assertEqual((recorder.state().lost, recorder.state().failed), (0, 0))
                with self.assertRaisesRegex(ValueError, "recorded already"):
                    hand.record(self.file.with_name("second.mcap"))
            ticks(0)
        seen = numpy.concatenate(seen)
        recording = feltwire.read(self.file)
        sample = recording["/hand/sample"]
        (first,) = numpy.nonzero(seen["time"] == sample["time"][0])[0]
        here = seen[first:first + len(sample)]
        self.assertEqual(len(here), len(sample))
        self.assertGreaterEqual(len(sample), 600)
        self.assertTrue(numpy.all(numpy.diff(here["number"]) == 1), "no tick is missing")
        numpy.testing.assert_array_equal(sample["time"], here["time"])
        numpy.testing.assert_array_equal(sample["position"], here["position"])
        numpy.testing.assert_array_equal(sample["held"], here["force"])
        numpy.testing.assert_array_equal(recording["/hand/account"]["balance"], here["balance"])
        self.assertGreater(here["force"][:, 2].max(), 0.0)
        self.assertEqual(recording.about["scene"], "plane")
        (mark,) = [values for name, values in recording.metadata if name == "mark"]
        self.assertEqual(mark["text"], "pressed")
        log_time = recording["/hand/sample"].log_time
        self.assertTrue(log_time[0] <= int(mark["time"]) <= log_time[-1])

    def test_errors_name_the_path_and_the_remedy(self):
        with self.server.join(**PATIENT) as hand:
            hand.record(self.file).close()
            with self.assertRaisesRegex(feltwire.Error, f"there is a file {self.file}; choose another path in file, or set replace"):
                hand.record(self.file)
            recorder = hand.record(self.file, replace=True)
            recorder.close()
            recorder.close()
            for call in (recorder.state, lambda: recorder.mark("x")):
                with self.assertRaisesRegex(ValueError, "closed"):
                    call()
            with self.assertRaisesRegex(ValueError, "file must end in .mcap"):
                hand.record("hand.csv")
            with self.assertRaisesRegex(feltwire.Error, "No such file or directory"):
                hand.record(self.file.parent / "no" / "hand.mcap")
            full = self.file.with_name("full.mcap")
            os.symlink("/dev/full", full)
            with self.assertRaisesRegex(feltwire.Error, f"{full}.*No space left"):
                hand.record(full, replace=True)
            self.assertIsNotNone(eventually("it goes on", hand.latest))

    def test_a_text_with_a_zero_byte_is_refused_and_not_cut(self):
        with self.server.join(**PATIENT) as hand:
            with self.assertRaisesRegex(ValueError, "has a zero byte"):
                hand.record(f"{self.file}\0.csv")
            self.assertFalse(self.file.exists())
            with self.assertRaisesRegex(ValueError, "needs a text or a path, not 5"):
                hand.record(5)
            with hand.record(self.file) as recorder:
                with self.assertRaisesRegex(ValueError, "has a zero byte"):
                    recorder.mark("grasped\0 by the wrong end")
                for text in (b"grasped", None, 5):
                    with self.subTest(text), self.assertRaisesRegex(ValueError, f"not {text!r}"):
                        recorder.mark(text)
        with self.server.admin() as admin, self.assertRaisesRegex(ValueError, "has a zero byte"):
            admin.request("set", "--object", "desk\0top", "--stiffness", 500)
        with self.server.admin() as admin, self.assertRaisesRegex(ValueError, "b'desk' is no text, number or path"):
            admin.request("set", "--object", b"desk", "--stiffness", 500)
        with self.assertRaisesRegex(ValueError, "has a zero byte"):
            self.server.join(device="simulated:path=press\0slide")
        with self.assertRaisesRegex(ValueError, "b'none' is no text, number or path"):
            self.server.join(mode=b"none")

    def test_it_may_be_closed_after_its_hand(self):
        with self.server.join(**PATIENT) as hand:
            recorder = hand.record(self.file, seconds=60)
            eventually("ticks", lambda: recorder.state().ticks > 20)
        recorder.close()
        self.assertGreater(len(feltwire.read(self.file.with_name("hand-0001.mcap"))["/hand/sample"]), 20)


if __name__ == "__main__":
    unittest.main()

"""The Python package against a server of its own: test_hand.py. FELTWIRE_LIBRARY and FELTWIRE_PROGRAMS name what was built."""
import ctypes
import os
import pathlib
import subprocess
import sys
import tempfile
import threading
import time
import unittest
import unittest.mock

from support import LONGEST, PATIENT, SOURCE, eventually, without_schedule
import feltwire

class Hands(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = feltwire.serve(SOURCE / "scenes/plane.json")

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def test_a_simulated_hand_feels_the_plane(self):
        with self.server.join(device="simulated:path=press", duration=2, **PATIENT) as hand:
            self.assertTrue(hand.wait(LONGEST))
            ticks = hand.ticks()
            self.assertEqual(without_schedule(hand.messages()), [])
        numbers = [int(tick["number"]) if hasattr(tick, "dtype") else tick.number for tick in ticks]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        forces = [tick["force"][2] if hasattr(tick, "dtype") else tick.force[2] for tick in ticks]
        self.assertGreater(max(forces), 0.3)

    def test_a_plugin_in_c_is_a_device(self):
        """examples/my_plugin.c: a spring pulls its mass into the wall."""
        plugin = pathlib.Path(os.environ["FELTWIRE_PROGRAMS"]).parent / "examples/my_plugin.so"
        with self.server.join(device=f"plugin:{plugin},await_still=0:0.2", **PATIENT) as hand:
            eventually("the plugin's mass is pushed back", lambda: (tick := hand.latest()) is not None and tick.force[2] > 0.1)
        with self.assertRaisesRegex((ValueError, feltwire.Error), "no_such_plugin"):
            self.server.join(device="plugin:./no_such_plugin.so", **PATIENT)

    def test_a_program_moves_a_hand(self):
        with self.server.join(device="caller:await_still=0", stale_after=0.2, hold_time=1, **PATIENT) as hand:
            start, normal = hand.session.start_position, hand.session.start_normal
            eventually("a tick", hand.latest)
            self.assertIn("must be homed first", hand.why_no_force())

            def go(height):
                """Returns the force along the normal, after the servo had the pose for a tick."""
                before = hand.latest().number
                force, _ = hand.exchange([start[i] + height * normal[i] for i in range(3)])
                eventually("a tick", lambda: hand.latest().number > before)
                return sum(force[i] * normal[i] for i in range(3))

            for step in range(120):
                go(0.004 - 5e-5 * step)
            eventually("the plane pushes", lambda: go(-0.002) > 0.3)
            eventually("a hand that is not moved gets no force", lambda: max(map(abs, hand.latest().force)) == 0.0)
            self.assertIn("no new position", hand.why_no_force())

    def test_a_program_makes_the_ticks(self):
        with self.server.join(device="stepped:await_still=0", hold_time=1, **PATIENT) as hand:
            start, normal = hand.session.start_position, hand.session.start_normal
            height = 0.004

            def pushed():
                nonlocal height
                place = [start[i] + height * normal[i] for i in range(3)]
                given = hand.step(place)
                self.assertIsNotNone(given)
                if hand._exchanged.number:  # of a machine that was not too busy for a tick
                    self.assertLess(max(abs(one - other) for one, other in zip(hand._exchanged.position, place)), 1e-12)
                height = max(height - 5e-5, -0.002)
                return sum(given[0][i] * normal[i] for i in range(3)) > 0.3

            eventually("the plane pushes", pushed)
            with self.assertRaisesRegex(ValueError, "stepped"):
                hand.exchange(start)
            hand.stop()
            eventually("the end", lambda: hand.step(start) is None)

    def test_one_thread_closes_while_others_ask(self):
        for _ in range(10):
            hand = self.server.join(**PATIENT)

            def ask():
                try:
                    while True:
                        hand.messages()
                        hand.wait(0.001)
                except ValueError:
                    pass

            threads = [threading.Thread(target=ask) for _ in range(2)]
            for thread in threads:
                thread.start()
            eventually("a tick", hand.latest)
            hand.close()
            for thread in threads:
                thread.join()

    def test_stop_does_not_wait_for_a_thread_that_waits(self):
        with self.server.join(**PATIENT) as hand:
            with hand._lock:  # as a thread in wait() holds it
                stopping = threading.Thread(target=hand.stop, daemon=True)
                stopping.start()
                stopping.join(LONGEST)
                self.assertFalse(stopping.is_alive())
            self.assertTrue(hand.wait(LONGEST))

    def test_ticks_as_arrays_and_as_lists(self):
        """An array of many ticks is no copy, and what is fetched later does not change it."""
        with self.server.join(device="simulated:path=press", **PATIENT) as hand, unittest.mock.patch("feltwire.hand._WORTH_KEEPING", 1):
            batches = []

            def fetch():
                batches.append(hand.ticks())
                return len(batches[-1])

            for _ in range(3):
                eventually("ticks", fetch)
            with unittest.mock.patch.dict(sys.modules, numpy=None):
                eventually("ticks", fetch)
        self.assertIsInstance(batches[-1], list)
        numbers = [int(tick["number"]) if hasattr(tick, "dtype") else tick.number for batch in batches for tick in batch]
        self.assertEqual(numbers, list(range(1, len(numbers) + 1)))
        self.assertFalse(any(batch.flags.owndata for batch in batches[:-1] if hasattr(batch, "flags") and len(batch)))

    def test_structs_have_the_layout_of_the_table(self):
        from feltwire import abi
        for struct, dtype in ((abi.Pose, abi.POSE_DTYPE), (abi.Session, abi.SESSION_DTYPE), (abi.Tick, abi.TICK_DTYPE)):
            self.assertEqual(ctypes.sizeof(struct), dtype["itemsize"])
            self.assertEqual([getattr(struct, name).offset for name in dtype["names"]], dtype["offsets"])

    def test_words_of_options(self):
        from feltwire.hand import _words
        self.assertEqual(_words({"center": (0, 0.1, 2), "rehearsal": False, "rehearse": True, "record": None, "max_force": 3}),
                         ["--center", "0,0.1,2", "--no-rehearsal", "--rehearse", "--max-force", "3"])

    def test_errors_are_exceptions_with_the_text(self):
        with self.assertRaisesRegex(feltwire.Refused, "no_such_scene"):
            self.server.join("no_such_scene", **PATIENT)
        with self.assertRaisesRegex(ValueError, "pth"):
            self.server.join(pth="press")
        with self.assertRaisesRegex(feltwire.ServerError, "127.0.0.1:1"):
            feltwire.join("127.0.0.1:1", "plane", fingerprint_file=self.server.fingerprint_file, token_file=self.server.token_file)
        with self.server.join(**PATIENT) as hand:
            with self.assertRaisesRegex(ValueError, "it moves itself"):
                hand.exchange((0, 0, 0))
        for call in (hand.latest, hand.ticks, hand.messages, hand.stop, hand.wait):
            with self.assertRaisesRegex(ValueError, "closed"):
                call()
        with self.assertRaisesRegex(ValueError, "feltwire-client only"):
            self.server.join(check=True)
        with self.assertRaisesRegex(FileNotFoundError, "no scene no_such_name"):
            feltwire.serve("no_such_name")
        with self.assertRaisesRegex(ValueError, "duration must be a number"):
            self.server.join(duration="long")
        with self.assertRaisesRegex(feltwire.Error, "no_such_file"):
            feltwire.serve("no_such_file.json")

    def test_a_server_that_ends_is_an_error_of_the_run(self):
        with feltwire.serve(SOURCE / "scenes/plane.json") as server:
            hand = server.join(reconnect=0, **PATIENT)
            eventually("an answer, so that the server has the hand's address", lambda: hand.latest() and hand.latest().reply_age >= 0.0)
        self.assertTrue(hand.wait(LONGEST))
        with self.assertRaisesRegex(feltwire.Error, "shutting down"):
            hand.close()

    def test_a_server_that_is_closed_says_so(self):
        server = feltwire.serve(SOURCE / "scenes/plane.json")
        process = server.process
        server.close()
        server.close()
        self.assertIsNotNone(process.poll())
        with self.assertRaisesRegex(ValueError, "the server is closed"):
            server.join()

    def test_a_server_that_nobody_closes_ends_with_the_program(self):
        code = ("import sys; sys.path.insert(0, sys.argv[1]); import feltwire; server = feltwire.serve(sys.argv[2]); "
                "print(server.process.pid)")
        done = subprocess.run([sys.executable, "-c", code, SOURCE / "client/python", SOURCE / "scenes/plane.json"], capture_output=True, text=True,
                              check=True)
        self.assertFalse(pathlib.Path(f"/proc/{int(done.stdout)}").exists())

    def test_a_missing_library_says_how_to_get_it(self):
        with tempfile.TemporaryDirectory() as folder:
            done = subprocess.run([sys.executable, "-c", "import feltwire; feltwire.join"], capture_output=True, text=True, cwd=SOURCE / "client/python",
                                  env={"FELTWIRE_LIBRARY": f"{folder}/none.so"}, check=False)
        self.assertNotEqual(done.returncode, 0)
        self.assertIn("set FELTWIRE_LIBRARY", done.stderr)


if __name__ == "__main__":
    unittest.main()

"""Observers and admins of the Python package: test_observer.py. FELTWIRE_LIBRARY and FELTWIRE_PROGRAMS name what was built."""
import contextlib
import ctypes
import os
import pathlib
import subprocess
import sys
import threading
import unittest

from support import LONGEST, PATIENT, SOURCE, eventually
import feltwire


def value(hand, field):
    """Of an array with NumPy, and of a struct without."""
    return hand[field] if hasattr(hand, "dtype") else getattr(hand, field)


class Observers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = feltwire.serve(SOURCE / "scenes/plane.json", max_sessions_per_client=32)

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def test_it_sees_a_hand_press_and_leave(self):
        with self.server.observe() as observer:
            with self.server.join(device="simulated:path=press", name="anna", **PATIENT):
                hands = []

                def pushed():
                    hands[:] = observer.hands()
                    return hands and value(hands[0], "commanded")[2] > 0.1 and value(hands[0], "force")[2] > 0.0

                eventually("the plane pushes", pushed)
                hand = hands[0]
                number = int(value(hand, "number"))
                eventually("the name", lambda: observer.name(number) == "anna")
                self.assertLess(value(hand, "position")[2], 0.02)
                self.assertGreater(value(hand, "samples"), 0)
            eventually("nobody", lambda: len(observer.hands()) == 0 and observer.latest().hands == 0)
            self.assertEqual(observer.messages(), [])
            self.assertEqual(len(observer.bodies()), 0)

    def test_each_state_is_newer(self):
        with self.server.observe(period=0.005) as observer:
            numbers = []
            for state in observer:
                numbers.append(state.number)
                if len(numbers) == 20:
                    break
            self.assertEqual(numbers, sorted(set(numbers)))
            self.assertTrue(observer.wait(LONGEST))
            self.assertFalse(observer.wait(0.0, after=2**60))

    def test_it_sees_sixteen_hands(self):
        with contextlib.ExitStack() as stack:
            for _ in range(16):
                stack.enter_context(self.server.join(rate=60, hold_time=1, **PATIENT))
            observer = stack.enter_context(self.server.observe())
            eventually("all hands", lambda: len(observer.hands()) == 16)
            numbers = [int(value(hand, "number")) for hand in observer.hands()]
            self.assertEqual(numbers, sorted(set(numbers)))

    def test_it_sees_bodies_move(self):
        with feltwire.serve(SOURCE / "scenes/workshop.json") as server, server.observe() as observer:
            eventually("a body", lambda: len(observer.bodies()) > 0)
            self.assertEqual(len(observer.bodies()), observer.latest().bodies)

    def test_a_server_that_ends_ends_the_observer(self):
        with feltwire.serve(SOURCE / "scenes/plane.json") as server:
            observer = server.observe(patience=0)
            eventually("a view", observer.latest)
        for _ in observer:
            pass
        self.assertFalse(observer.wait())
        with self.assertRaisesRegex(feltwire.Error, "shutting down"):
            observer.close()

    def test_errors_are_exceptions_with_the_text(self):
        with self.assertRaisesRegex(feltwire.Refused, "no_such_scene"):
            self.server.observe("no_such_scene")
        with self.assertRaisesRegex(ValueError, "period"):
            self.server.observe(period=0)
        with self.assertRaisesRegex(feltwire.ServerError, "127.0.0.1:1"):
            feltwire.observe("127.0.0.1:1", "plane", fingerprint_file=self.server.fingerprint_file, token_file=self.server.token_file)
        observer = self.server.observe()
        observer.close()
        observer.close()
        for call in (observer.latest, observer.hands, observer.bodies, observer.messages, observer.wait, lambda: observer.name(1)):
            with self.assertRaisesRegex(ValueError, "closed"):
                call()

    def test_one_thread_closes_while_others_ask(self):
        for _ in range(5):
            observer = self.server.observe()

            def ask():
                with contextlib.suppress(ValueError):
                    while True:
                        observer.messages()
                        observer.hands()
                        observer.name(1)
                        observer.wait(0.001)

            threads = [threading.Thread(target=ask) for _ in range(2)]
            for thread in threads:
                thread.start()
            eventually("a view", observer.latest)
            observer.close()
            for thread in threads:
                thread.join()

    def test_structs_have_the_layout_of_the_table(self):
        from feltwire import abi
        for struct, dtype in ((abi.SceneState, abi.SCENE_STATE_DTYPE), (abi.SeenHand, abi.SEEN_HAND_DTYPE), (abi.SeenBody, abi.SEEN_BODY_DTYPE)):
            self.assertEqual(ctypes.sizeof(struct), dtype["itemsize"])
            self.assertEqual([getattr(struct, name).offset for name in dtype["names"]], dtype["offsets"])


class Admins(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = feltwire.serve(SOURCE / "scenes/plane.json")
        cls.admin = cls.server.admin()

    @classmethod
    def tearDownClass(cls):
        cls.admin.close()
        cls.server.close()

    def test_it_lists_changes_and_evicts(self):
        self.assertEqual([scene["scene"] for scene in self.admin.scenes()], ["plane"])
        with self.server.join(name="anna", reconnect=0, **PATIENT) as hand:
            (session,) = self.admin.sessions("plane")
            self.assertEqual((session["client"], session["role"]), ("anna", "operator"))
            eventually("an answer, so that the server has the hand's address", lambda: hand.latest() and hand.latest().reply_age >= 0.0)
            self.assertEqual(self.admin.evict(session["number"])["client"], "anna")
            self.assertTrue(hand.wait(LONGEST))
            with self.assertRaises(feltwire.Error):
                hand.close()
        self.assertEqual(self.admin.reload("plane"), {"scene": "plane"})
        self.assertIn("scenes", self.admin.stats())

    def test_errors_are_exceptions_with_the_text(self):
        for wrong, text in ((lambda: self.admin.evict(77), "no session 77"), (lambda: self.admin.request("sesions"), "did you mean sessions"),
                            (lambda: self.admin.set(objct="plane"), "objct"), (self.admin.request, "give a command")):
            with self.assertRaisesRegex(ValueError, text):
                wrong()
        with self.assertRaisesRegex(feltwire.Refused, "no_such_scene"):
            self.admin.reload("no_such_scene")
        with self.assertRaisesRegex(feltwire.Refused, "flight"):
            self.admin.record()
        other = feltwire.admin(self.server.address, fingerprint_file=self.server.fingerprint_file, token_file=self.server.token_file)
        with self.assertRaisesRegex(feltwire.Refused, "admin"):
            other.set(gravity=(0, 0, -1))
        other.close()
        with self.assertRaisesRegex(ValueError, "closed"):
            other.scenes()

    def test_the_examples_run(self):
        environment = dict(os.environ, PYTHONPATH=str(SOURCE / "client/python"), FELTWIRE_FINGERPRINT_FILE=self.server.fingerprint_file,
                           FELTWIRE_TOKEN_FILE=str(pathlib.Path(self.server.token_file).parent / "admin.token"))

        def run(example, *words):
            done = subprocess.run([sys.executable, SOURCE / "examples" / example, self.server.address, "plane", *words], text=True,
                                  capture_output=True, timeout=LONGEST, env=environment, check=False)
            self.assertEqual((done.returncode, done.stderr), (0, ""))
            return done.stdout

        with self.server.join(device="simulated:path=press", name="anna", **PATIENT):
            self.assertIn("1 hands", run("my_observer.py", "1"))
            out = run("my_admin.py", "desk")
            self.assertIn("300", out)
            self.assertIn("anna, role operator", out)


if __name__ == "__main__":
    unittest.main()

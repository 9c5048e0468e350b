#!/usr/bin/env python3
"""A robot of a Python program, and a hand of another kind that leads it."""
import asyncio
import ctypes
import threading
import time
import unittest

from support import LONGEST, PATIENT, SOURCE, eventually
import feltwire

SEAT = SOURCE / "scenes/teleoperation/seat.json"
STIFFNESS, FLOOR, START = 1000.0, 2000.0, 0.01  # [N/m], [N/m], [m]
READY, ENGAGED, FAULT = 1, 2, 5  # states between hand and robot
HIGH = 0.3  # [m] of the hand, above the desk


class Robot(threading.Thread):
    """A mass over a floor, which a controller draws to its target. The thread exchanges its state for targets."""

    def __init__(self, follower):
        super().__init__()
        self.follower, self.height, self.speed, self.force, self.target = follower, START, 0.0, 0.0, START
        self.silent = self.stopped = False
        self.error = None

    def move(self, seconds):
        for _ in range(max(1, round(min(seconds, 0.05) / 1e-4))):
            self.force = max(0.0, -FLOOR * self.height)
            self.speed += 1e-4 / 2.0 * (STIFFNESS * (self.target - self.height) - 90.0 * self.speed + self.force)
            self.height += 1e-4 * self.speed

    def run(self):
        try:
            last = time.monotonic()
            for _ in self.follower.paced(400):
                now = time.monotonic()
                self.move(now - last)
                last = now
                if self.silent:
                    continue
                target = self.follower.exchange((0.0, 0.0, self.height), velocity=(0.0, 0.0, self.speed), force=(0.0, 0.0, self.force),
                                                stopped=self.stopped)
                if target is None:
                    return
                self.target = target.position[2]
        except Exception as error:  # the test shows it
            self.error = error


class Followers(unittest.TestCase):
    @classmethod
    def setUpClass(cls):
        cls.server = feltwire.serve(SEAT, max_sessions_per_client=16)

    @classmethod
    def tearDownClass(cls):
        cls.server.close()

    def follow(self, **options):
        """The seat is free a moment after the last robot has left."""
        return eventually("a free seat", lambda: self.try_to_follow(options))

    def try_to_follow(self, options):
        try:
            return self.server.follow(stiffness=STIFFNESS, **options)
        except feltwire.ServerError:
            return None

    def lead(self):
        return self.server.join(device="caller:await_still=0", lead=0.2, stale_after=0.2, hold_time=1, **PATIENT)

    def engage(self, hand, height):
        """Shows a released switch, then presses it."""
        for deadman, state in ((False, READY), (True, ENGAGED)):
            def there():
                hand.exchange((0, 0, height), deadman=deadman)
                return hand.latest() and hand.latest().lead_state == state
            eventually(f"state {state}", there)

    def test_the_robot_follows_and_the_hand_feels_its_wall(self):
        with self.follow() as follower, self.lead() as hand:
            robot = Robot(follower)
            robot.start()
            try:
                self.engage(hand, HIGH)
                self.assertEqual(follower.state, "engaged")

                height = HIGH

                def lower():
                    """At the pace of a person: a robot does not follow a jump. A machine that lets the hand wait makes one; then the switch is
                    released and pressed again."""
                    nonlocal height
                    time.sleep(0.001)
                    state = hand.latest().lead_state
                    height = max(height - 5e-5, HIGH - 0.03) if state == ENGAGED else height
                    return hand.exchange((0, 0, height), deadman=state in (READY, ENGAGED))[0][2]

                eventually("the robot follows", lambda: lower() is not None and robot.height < START / 2)
                eventually("the wall of the robot", lambda: lower() > 0.5)
                eventually("the robot presses its floor", lambda: lower() is not None and robot.force > 0.5)

                # A robot of which nothing is heard is not led, and the hand is told.
                robot.silent = True

                def told():
                    force = hand.exchange((0, 0, height), deadman=True)[0][2]
                    return force == 0.0 and hand.latest().lead_state == FAULT

                eventually("no force, and the hand knows why", told)
                stands = follower.latest().position[2]
                for _ in range(30):
                    hand.exchange((0, 0, height + 0.01), deadman=True)
                    time.sleep(0.001)
                self.assertEqual(follower.latest().position[2], stands)
                robot.silent = False
                self.engage(hand, height + 0.01)
                robot.stopped = True
                eventually("a protective stop", lambda: hand.exchange((0, 0, height + 0.01), deadman=True) and hand.latest().lead_state == FAULT)
            finally:
                follower.stop()
                robot.join(LONGEST)
            self.assertIsNone(robot.error)
            self.assertTrue(follower.wait(LONGEST))
            self.assertIsNone(follower.exchange((0, 0, 0)))
            self.assertEqual(follower.messages(), [])

    def test_states_that_are_wrong_are_named(self):
        with self.follow(period=0.005) as follower:
            for wrong, text in (({"position": (0, 0, float("nan"))}, "position is not"), ({"position": (0, 0)}, "position must be 3 numbers"),
                                ({"position": (0, 0, 0), "orientation": (2, 0, 0, 0)}, "orientation is no unit"),
                                ({"position": (0, 0, 0), "gripper": -1}, "gripper must be"),
                                ({"position": (0, 0, 0), "force": (1, 2)}, "force must be 3 numbers")):
                with self.assertRaisesRegex(ValueError, text):
                    follower.exchange(**wrong)
            target = follower.exchange((0.1, 0.2, 0.3))
            self.assertEqual(tuple(target.position), (0.1, 0.2, 0.3))
            self.assertLess(target.age, 0.0)
            self.assertEqual(follower.state, "disabled")
        with self.assertRaisesRegex(ValueError, "closed"):
            follower.exchange((0, 0, 0))
        follower.close()

    def test_options_that_are_wrong_are_named(self):
        for wrong, text in (({"stiffness": 0}, "stiffness must be"), ({"period": 1}, "period must be"), ({"locked": ["w"]}, "locked has 'w'"),
                            ({"workspace": ((0, 0, 0), (0, 1, 1))}, "workspace_low must be"), ({"workspace": [1]}, "two corners"),
                            ({"workspace": 5}, "two corners"), ({"locked": 5}, "locked must be a list"), ({"seat": "a\0b"}, "has a zero byte"),
                            ({"mass": "much"}, "mass must be a number")):
            with self.assertRaisesRegex(ValueError, text):
                self.server.follow(**{"stiffness": STIFFNESS, **wrong})
        with self.assertRaisesRegex(feltwire.Refused, "does not join as follower"):
            feltwire.follow(self.server.address, "seat", stiffness=STIFFNESS, fingerprint_file=self.server.fingerprint_file,
                            token_file=self.server.token_file)
        with self.assertRaisesRegex(ValueError, "no scene sofa"):
            self.server.follow("sofa", stiffness=STIFFNESS)

    def test_it_has_an_event_loop_too(self):
        async def run():
            token = self.server._token("follower", "seat")
            while True:
                try:
                    follower = await feltwire.aio.follow(self.server.address, "seat", stiffness=STIFFNESS, token_file=token,
                                                         fingerprint_file=self.server.fingerprint_file)
                    break
                except feltwire.ServerError:
                    await asyncio.sleep(0.05)
            async with follower:
                for rate in (0, -5, float("nan")):
                    with self.assertRaisesRegex(ValueError, "rate must be above 0 Hz"):
                        await follower.paced(rate).__anext__()
                async for _ in follower.paced(200):
                    target = follower.exchange((0.0, 0.0, START))
                    if target.number > 50:
                        break
                self.assertEqual(follower.state, "disabled")
                follower.stop()
                self.assertTrue(await follower.wait(LONGEST))
                self.assertIsNone(follower.exchange((0.0, 0.0, START)))
            return tuple(follower.follower._target.position)

        self.assertEqual(asyncio.run(asyncio.wait_for(run(), 2 * LONGEST)), (0.0, 0.0, START))

    def test_structs_have_the_layout_of_the_table(self):
        from feltwire import abi
        for struct, dtype in ((abi.RobotState, abi.ROBOT_STATE_DTYPE), (abi.RobotTarget, abi.ROBOT_TARGET_DTYPE)):
            self.assertEqual(ctypes.sizeof(struct), dtype["itemsize"])
            self.assertEqual([getattr(struct, name).offset for name in dtype["names"]], dtype["offsets"])


if __name__ == "__main__":
    unittest.main()

#!/usr/bin/env python3
"""A hand in the physics of a Python program."""
import math
import unittest

from support import PATIENT, eventually
import feltwire

STIFFNESS, RADIUS = 5000.0, 0.05  # [N/m], [m]
# A busy machine may let the program wait, and the force must not fade meanwhile.
OPTIONS = {**PATIENT, "hold_time": 1, "stiffness": STIFFNESS}


def sphere(position, _time=0.0):
    """A ball below the origin."""
    away = (position[0], position[1], position[2] + RADIUS)
    length = math.hypot(*away)
    normal = [one / length for one in away]
    return [feltwire.Patch([RADIUS * normal[0], RADIUS * normal[1], RADIUS * normal[2] - RADIUS], normal, STIFFNESS, curvature=1.0 / RADIUS)]


class Worlds(unittest.TestCase):
    def test_a_hand_feels_the_physics_and_stale_physics_fades(self):
        with feltwire.World(device="simulated:path=press,depth=0.005", **OPTIONS) as world:
            felt = []

            def pushes():
                tick = world.latest()
                if tick is None:
                    return False
                world.touch(sphere(tick.position), 0.02, tick.time)
                felt.append(tick.force[2])
                return tick.force[2] > 0.5

            eventually("the sphere pushes", pushes)
            eventually("the force has faded", lambda: world.latest().force[2] == 0.0)
            self.assertIn("hold_time", world.why_no_force())
            world.stop()
            self.assertTrue(world.wait(60))
            self.assertEqual(world.why_no_force(), "the run has ended")

    def test_run_calls_the_physics_until_its_time_is_over(self):
        calls = []

        def physics(position, time):
            calls.append(time)
            return sphere(position)

        with feltwire.World(device="simulated:path=press", **OPTIONS) as world:
            world.run(physics, reach=0.02, rate=200, duration=1)
            self.assertGreater(len(calls), 2)
            self.assertLessEqual(len(calls), 201)
            self.assertEqual(calls, sorted(calls))
            world.stop()
            world.run(physics, reach=0.02)  # ends with the run

    def test_a_force_is_felt_too(self):
        with feltwire.World(device="simulated:path=press", **OPTIONS) as world:
            def pushes():
                tick = world.latest()
                if tick is None:
                    return False
                world.push((0, 0, max(0.0, -STIFFNESS * tick.position[2])), STIFFNESS, time=tick.time)
                return tick.force[2] > 0.5

            eventually("the spring pushes", pushes)

    def test_nothing_is_felt_where_nothing_is(self):
        with feltwire.World(device="simulated:path=press", **OPTIONS) as world:
            world.run(lambda position, time: [], reach=0.05, duration=0.5)
            self.assertTrue(all(one == 0.0 for one in world.latest().force))

    def test_wrong_values_are_named(self):
        with self.assertRaisesRegex(ValueError, "stiffness"):
            feltwire.World(stiffness=0.0)
        for option in ({"token_file": "token"}, {"local_model": "off"}, {"local_model": True}, {"link": "delay=1"}):
            with self.assertRaisesRegex(ValueError, f"^{next(iter(option))}(=False)? needs a server: leave it out"):
                feltwire.World(**OPTIONS, **option)
        with self.assertRaisesRegex(ValueError, "pth"):
            feltwire.World(pth="press", **OPTIONS)
        with feltwire.World(**OPTIONS) as world:
            for name, value in (("point", (0, 0, math.nan)), ("normal", (0, 0, 2)), ("stiffness", -1), ("stiffness", 2 * STIFFNESS), ("dynamic_friction", 0.5)):
                patch = feltwire.Patch((0, 0, 0), (0, 0, 1), STIFFNESS)._replace(**{name: value})
                with self.assertRaisesRegex(ValueError, rf"patches\[0\].{name}"):
                    world.touch([patch], 0.02)
            with self.assertRaisesRegex(ValueError, r"patches\[0\].point must be 3 numbers"):
                world.touch([feltwire.Patch([[0, 0, 0]], (0, 0, 1), STIFFNESS)], 0.02)
            with self.assertRaisesRegex(ValueError, "must be a feltwire.Patch"):
                world.touch([{"point": (0, 0, 0)}], 0.02)
            with self.assertRaisesRegex(ValueError, "where nothing is near"):
                world.touch(None, 0.02)
            with self.assertRaisesRegex(ValueError, "rate must be above 0"):
                next(world.paced(0))
            with self.assertRaisesRegex(ValueError, "reach"):
                world.touch([], 5.0)
            with self.assertRaisesRegex(ValueError, "at most 3"):
                world.touch(4 * [feltwire.Patch((0, 0, 0), (0, 0, 1), STIFFNESS)], 0.02)
            with self.assertRaisesRegex(ValueError, "wrench.force"):
                world.push((math.nan, 0, 0))
        with self.assertRaisesRegex(ValueError, "closed"):
            world.touch([], 0.02)

    def test_a_hand_in_a_scene_of_a_server_has_no_physics_of_its_own(self):
        self.assertFalse(hasattr(feltwire.Hand, "touch"))


if __name__ == "__main__":
    unittest.main()

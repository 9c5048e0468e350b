#!/usr/bin/env python3
"""A device of six degrees of freedom: the program gives position and orientation, and applies force and torque.

    examples/python/six_dof_device.py [SECONDS]

The tool of the scene is a brick. A hand holds it askew and presses it on a table, whose torque lays it flat. A real device takes the place of
Brick: it measures the pose, applies force and torque, and has a watchdog of its own.
"""
import math
import pathlib
import sys
import time
from typing import Sequence, Tuple

import feltwire

BODY = pathlib.Path(__file__).resolve().parents[2] / "scenes/body.json"


class Brick:
    """0.3 kg on a damped spring whose rest is 5 mm inside the table, and 3e-4 kg m^2 on a damped spring that tilts it by 0.2 rad."""

    WANTED = 0.2  # [rad] about y

    def __init__(self, start: Sequence[float]):
        self.start = start
        self.height, self.speed = 0.01, 0.0  # [m], [m/s] above the start, which is on the table
        self.tilt, self.turning = self.WANTED, 0.0  # [rad], [rad/s] about y

    def position(self) -> Tuple[float, ...]:
        """[m]"""
        return self.start[0], self.start[1], self.start[2] + self.height

    def orientation(self) -> Tuple[float, ...]:
        """The unit quaternion w, x, y, z."""
        return math.cos(self.tilt / 2), 0.0, math.sin(self.tilt / 2), 0.0

    def step(self, force: float, torque: float, time_step: float) -> None:
        """force [N] upwards, torque [N m] about y."""
        self.speed += (force - 200 * (self.height + 0.005) - 8 * self.speed) / 0.3 * time_step
        self.height += self.speed * time_step
        self.turning += (torque - 0.05 * (self.tilt - self.WANTED) - 0.01 * self.turning) / 3e-4 * time_step
        self.tilt += self.turning * time_step


def main(duration: float) -> None:
    with feltwire.serve(BODY) as server:
        with server.join(device="caller:await_still=0", spec="simulated_6dof", rate=200, stale_after=0.1, hold_time=0.5,
                         flight_recorder="off") as hand:
            brick = Brick(hand.session.start_position)
            most, flattest, before = 0.0, brick.tilt, time.monotonic()
            end = before + duration
            while before < end:
                given = hand.exchange(brick.position(), brick.orientation())
                if given is None:  # The run has ended: nothing may be applied.
                    break
                force, torque = given
                most, flattest = max(most, -torque[1]), min(flattest, brick.tilt)
                time.sleep(0.005)
                now = time.monotonic()
                brick.step(force[2], torque[1], min(now - before, 0.02))
                before = now
            print(f"the hand tilts the brick by {1e3 * brick.WANTED:.0f} mrad, and the table laid it down to {1e3 * flattest:.0f}; "
                  f"now it is {1e3 * brick.tilt:.0f}; largest torque {1e3 * most:.1f} mN m")
            print(hand.why_no_force() or "it feels the table")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 2.0)

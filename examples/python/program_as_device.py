#!/usr/bin/env python3
"""The program is the device: it gives the poses of a mass on a spring, and applies the force of the scene to that mass.

    examples/python/program_as_device.py [SECONDS]

A real device takes the place of Mass: it measures the position and applies the force, and it has a watchdog of its own.
"""
import pathlib
import sys
import time
from typing import Tuple

import feltwire

PLANE = pathlib.Path(__file__).resolve().parents[2] / "scenes/plane.json"


class Mass:
    """A mass of 0.3 kg on a damped spring of 100 N/m, whose rest position is 5 mm inside the plane."""

    def __init__(self, start: Tuple[float, ...], normal: Tuple[float, ...]):
        self.start, self.normal = start, normal
        self.height, self.speed = 0.01, 0.0  # [m] and [m/s] along the normal

    def position(self) -> Tuple[float, ...]:
        """[m]"""
        return tuple(one + self.height * axis for one, axis in zip(self.start, self.normal))

    def step(self, force: float, time_step: float) -> None:
        """force [N] along the normal."""
        self.speed += (force - 100 * (self.height + 0.005) - 6 * self.speed) / 0.3 * time_step
        self.height += self.speed * time_step


def main(duration: float) -> None:
    with feltwire.serve(PLANE) as server:
        with server.join(device="caller:await_still=0", rate=200, stale_after=0.1, hold_time=0.5, flight_recorder="off") as hand:
            normal = tuple(hand.session.start_normal)
            mass = Mass(tuple(hand.session.start_position), normal)
            largest, before = 0.0, time.monotonic()
            end = before + duration
            while before < end:
                given = hand.exchange(mass.position())
                if given is None:  # The run has ended: nothing may be applied.
                    break
                force = sum(one * axis for one, axis in zip(given[0], normal))
                largest = max(largest, force)
                time.sleep(0.005)
                now = time.monotonic()
                mass.step(force, min(now - before, 0.02))
                before = now
            print(f"the mass rests {1e3 * mass.height:.2f} mm above the plane, with {force:.2f} N; largest force {largest:.2f} N")
            print(hand.why_no_force() or "it feels the plane")


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 2.0)

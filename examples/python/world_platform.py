#!/usr/bin/env python3
"""A hand on a platform that rises and sinks, computed 100 times a second. The hand feels it at 1 kHz: the platform's speed is told too, so
it moves on between two answers.

    examples/python/world_platform.py [SECONDS]
"""
import math
import sys

import feltwire

AMPLITUDE, FREQUENCY = 0.003, 0.5  # [m], [Hz]


def platform(position, time):
    """The surface under the tool at this time."""
    phase = 2.0 * math.pi * FREQUENCY * time
    height, speed = AMPLITUDE * math.sin(phase), 2.0 * math.pi * FREQUENCY * AMPLITUDE * math.cos(phase)
    return [feltwire.Patch(point=(position[0], position[1], height), normal=(0, 0, 1), stiffness=800, velocity=(0, 0, speed),
                           static_friction=0.5, dynamic_friction=0.4)]


def main(seconds=4.0):
    with feltwire.World(stiffness=800, device="simulated:path=press,depth=0.01") as world:
        world.run(platform, reach=0.05, rate=100, duration=seconds)
        ticks = world.ticks()
    forces = [tick["force"][2] if hasattr(tick, "dtype") else tick.force[2] for tick in ticks]
    print(f"the platform pushed with at most {max(forces):.2f} N, in {len(forces)} ticks")


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))

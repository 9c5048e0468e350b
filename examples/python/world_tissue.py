#!/usr/bin/env python3
"""A hand presses soft tissue: columns of springs and dampers that pull their neighbours along, and get stiffer as they are pressed. Python
computes them 100 times a second.

    examples/python/world_tissue.py [SECONDS]
"""
import sys

import feltwire

COUNT, SPACING = 31, 0.004  # columns in a row, [m]
SKIN = 1500.0  # [N/m] of the surface under the tool
SOFT, HARD, SHARED, DAMPING = 150.0, 4e6, 120.0, 1.5  # [N/m], [N/m^3], [N/m] between neighbours, [N s/m]


class Tissue:
    """A row of columns along x. Their surface is z = 0 where nobody presses."""

    def __init__(self):
        self.depth = [0.0] * COUNT  # [m]

    def surface(self, x):
        """The depth of the surface [m] at x."""
        at = min(max(x / SPACING + COUNT // 2, 0.0), COUNT - 1.001)
        i, part = int(at), at % 1.0
        return (1.0 - part) * self.depth[i] + part * self.depth[i + 1]

    def advance(self, position, seconds, steps=20):
        """The tool presses the column under it for that time."""
        under = round(min(max(position[0] / SPACING + COUNT // 2, 1), COUNT - 2))
        for _ in range(steps):
            old = list(self.depth)
            for i in range(1, COUNT - 1):
                depth = old[i]
                force = -(SOFT + HARD * depth * depth) * depth + SHARED * (old[i - 1] + old[i + 1] - 2.0 * depth)
                if i == under:
                    force += SKIN * max(0.0, -position[2] - depth)
                self.depth[i] += seconds / steps * force / DAMPING


def main(seconds=4.0):
    tissue, rate, most = Tissue(), 100.0, 0.0

    def press(position, _time):
        tissue.advance(position, 1.0 / rate)
        return [feltwire.Patch(point=(position[0], position[1], -tissue.surface(position[0])), normal=(0, 0, 1), stiffness=SKIN)]

    with feltwire.World(stiffness=SKIN, device="simulated:path=press,depth=0.012") as world:
        world.run(press, reach=0.02, rate=rate, duration=seconds)
        ticks = world.ticks()
    forces = [tick["force"][2] if hasattr(tick, "dtype") else tick.force[2] for tick in ticks]
    most = max(forces)
    print(f"the tissue pushed with at most {most:.2f} N, and is {1e3 * max(tissue.depth):.1f} mm deep")


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))

#!/usr/bin/env python3
"""Asks the laboratory how much energy a stiff wall gives to the hand with each bounding method, by the filter `feltwire-lab bound`. A bound
gives no more than the device's damping takes.

    examples/python/lab_verb.py
"""
import math

import feltwire

PERIOD, DAMPING, STIFFNESS = 0.001, 0.5, 5000.0  # [s], [N s/m], [N/m]


def press() -> dict:
    """A hand that goes 1 mm into a wall and out again in 0.2 s: displacements [m] and the wall's force [N], tick by tick. The device is a
    sample late, so that a wall without a bound gives back more energy than it took."""
    count = 200
    depth = [1e-3 * math.sin(math.pi * i / count) for i in range(count + 1)]
    zeros = [0.0] * count
    return {"dx": zeros, "dy": zeros, "dz": [-(depth[i + 1] - depth[i]) for i in range(count)],
            "ex": zeros, "ey": zeros, "ez": [STIFFNESS * depth[i] for i in range(count)], "fx": zeros, "fy": zeros, "fz": zeros}


def main() -> None:
    for mode in ("none", "per_axis", "contact_frame"):
        table = feltwire.lab.bound(mode=mode, period=PERIOD, damping=DAMPING, table=press()).table
        largest = max(float(force[2]) for force in table["held"])
        print(f"{mode:14} largest force {largest:.2f} N, energy given to the hand {1e6 * float(table['energy'][len(table) - 1]):+.1f} uJ")


if __name__ == "__main__":
    main()

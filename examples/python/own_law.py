#!/usr/bin/env python3
"""A bounding law in Python, judged by the laboratory: own_law.py [--wrong-sign]

The law stores the work of the hand on the device and the energy that the device's damping dissipates. It passes a force only as far as the
store covers the most that the hand can take back with it. It is that of examples/my_bound.cpp and examples/my_law.c, for forces without
torque. Exit status 1: the law broke its promise, as with the wrong sign.
"""
import math
import sys

import feltwire


class EnergyStore:
    """The laboratory makes one for each run, and calls step() at each servo sample."""

    promise = "port"  # the hand never gets more energy than the device dissipated, and the store covers the energy at stake
    sign = 1.0  # factor of the hand's work -f.dx

    def __init__(self, device):
        self.damping = device.least_damping  # b [N s/m]
        self.period = device.period  # T [s]
        self.energy = 0.0  # [J]
        self.held = (0.0, 0.0, 0.0)  # [N] on the hand since the last step

    def step(self, step):
        moved = dot(step.displacement, step.displacement)
        self.energy += self.damping / step.hold_time * moved - self.sign * dot(self.held, step.displacement)
        allowed = math.sqrt(4.0 * self.damping / self.period * max(0.0, self.energy - 1e-290))
        wanted = math.sqrt(dot(step.force, step.force))
        share = min(1.0, allowed / max(wanted, 1e-300))
        rendered = tuple(share * one for one in step.force)
        self.hold(rendered)
        return rendered

    def set_held(self, held):
        """Another force was held than step() returned, after a limit or a fade: elastic, frictional and torque."""
        elastic, frictional, _ = held
        self.hold(tuple(a + b for a, b in zip(elastic, frictional)))

    def hold(self, force):
        self.held = force
        if self.damping > 0.0:  # without damping no force is ever allowed
            self.energy = min(self.energy, dot(force, force) * self.period / (4.0 * self.damping))


class WrongSign(EnergyStore):
    sign = -1.0


def dot(a, b):
    return a[0] * b[0] + a[1] * b[1] + a[2] * b[2]


def main():
    law = WrongSign if "--wrong-sign" in sys.argv[1:] else EnergyStore
    try:
        feltwire.lab.extremes(law, hands=2)
    except feltwire.lab.LawFailed as error:
        print(error)
        return 1
    print("no stress makes it break its promise")
    print(feltwire.lab.compare(law, methods=["none", "contact_frame"], tasks=["tap"]))
    return 0


if __name__ == "__main__":
    sys.exit(main())

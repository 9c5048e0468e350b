#!/usr/bin/env python3
"""A hand presses a ball into a cloth of point masses and springs, which NumPy computes 100 times a second. Needs NumPy.

    examples/python/world_cloth.py [SECONDS]
"""
import sys

import numpy as np

import feltwire

COUNT, SIZE = 21, 0.1  # points along an edge, [m]
MASS, SPRING, DRAG = 5e-4, 60.0, 5e-3  # [kg] of a point, [N/m] between neighbours, [N s/m]
BALL, CONTACT = 0.012, 150.0  # [m] radius of the tool, [N/m] of a point that the ball touches
STEP = 5e-4  # [s]
REST = SIZE / (COUNT - 1)


class Cloth:
    """Held at its four edges, in the plane z = 0."""

    def __init__(self):
        line = np.linspace(-SIZE / 2, SIZE / 2, COUNT)
        self.place = np.stack([*np.meshgrid(line, line, indexing="ij"), np.zeros((COUNT, COUNT))], axis=-1)
        self.speed = np.zeros_like(self.place)
        self.free = np.zeros((COUNT, COUNT, 1))
        self.free[1:-1, 1:-1] = 1.0

    def springs(self):
        """The forces [N] of the springs on all points. They are stretched at rest by a tenth."""
        force = np.zeros_like(self.place)
        for axis in (0, 1):
            way = np.diff(self.place, axis=axis)
            length = np.linalg.norm(way, axis=-1, keepdims=True)
            pull = SPRING * (length - 0.9 * REST) * way / length
            first, last = [slice(None)] * 2, [slice(None)] * 2
            first[axis], last[axis] = slice(None, -1), slice(1, None)
            force[tuple(first)] += pull
            force[tuple(last)] -= pull
        return force

    def push(self, ball):
        """The forces [N] of the ball on all points."""
        away = self.place - ball
        distance = np.maximum(np.linalg.norm(away, axis=-1, keepdims=True), 1e-9)
        return CONTACT * np.maximum(BALL - distance, 0.0) * away / distance

    def advance(self, ball, seconds):
        """Returns the force [N] on the ball, and its stiffness [N/m] along that force."""
        for _ in range(round(seconds / STEP)):
            force = self.springs() + self.push(ball) - DRAG * self.speed
            self.speed += STEP / MASS * force * self.free
            self.place += STEP * self.speed
        contact = self.push(ball)
        touched = int(np.count_nonzero(np.linalg.norm(contact, axis=-1)))
        return -contact.sum(axis=(0, 1)), CONTACT * touched


def main(seconds=4.0):
    cloth, rate, most = Cloth(), 100.0, 0.0
    with feltwire.World(stiffness=5000, start=(0, 0, BALL), device="simulated:path=press,depth=0.02") as world:
        for _ in world.paced(rate, seconds):
            tick = world.latest()
            force, stiffness = cloth.advance(np.array(tick.position), 1.0 / rate)
            world.push(force, stiffness, time=tick.time)
            most = max(most, tick.force[2])
    print(f"the cloth pushed with at most {most:.2f} N, and is {-1e3 * cloth.place[..., 2].min():.1f} mm deep")


if __name__ == "__main__":
    main(*map(float, sys.argv[1:]))

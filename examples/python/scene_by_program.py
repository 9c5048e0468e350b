#!/usr/bin/env python3
"""Writes a scene of rounded bumps in a grid, has the server check it, and scans the force along a line, without a device.

    examples/python/scene_by_program.py [SCENE.json]
"""
import sys

import feltwire


def bumps(count: int = 5, distance: float = 0.02) -> feltwire.Scene:
    """A soft plate with count x count balls of rising stiffness sunk into it, `distance` [m] apart."""
    scene = feltwire.Scene("bumps", description="Balls of rising stiffness in a soft plate.")
    scene.material("foam", 300, damping=0.5)
    scene.plane("plate", material="foam")
    middle = (count - 1) / 2
    for row in range(count):
        material = scene.material(f"rubber {row}", 400 + 100 * row, static_friction=0.5, dynamic_friction=0.4)
        for column in range(count):
            place = [distance * (column - middle), distance * (row - middle), -0.003]
            scene.sphere(f"bump {row} {column}", 0.006, position=place, material=material)
    scene.tool("tip")
    scene.tool("finger", sphere={"radius": 0.006})
    return scene


def main() -> None:
    scene = bumps()
    print(scene.check().text.splitlines()[0])
    line = [{"t": 0.01 * i, "x": -0.05 + 0.002 * i, "y": 0.0, "z": 0.001} for i in range(51)]
    elastic = feltwire.lab.touch(scene=scene, table=line).table["elastic"]
    for row, force in zip(line, elastic):
        print(f"x {1e3 * row['x']:6.1f} mm  {'#' * round(20 * float(force[2]))} {float(force[2]):.2f} N")
    if len(sys.argv) > 1:
        scene.save(sys.argv[1])


if __name__ == "__main__":
    main()

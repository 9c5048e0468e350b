#!/usr/bin/env python3
"""Records a hand, reads the recording as arrays, and measures how stiff the plane felt. Needs numpy, and matplotlib for the picture.

    examples/python/recording_to_numpy.py [PICTURE.png]
"""
import pathlib
import sys
import tempfile

import numpy

import feltwire

PLANE = pathlib.Path(__file__).resolve().parents[2] / "scenes/plane.json"


def main() -> None:
    with tempfile.TemporaryDirectory() as folder, feltwire.serve(PLANE) as server:
        file = pathlib.Path(folder) / "hand.mcap"
        with server.join(device="simulated:path=taps", duration=3, record=file, flight_recorder="off") as hand:
            hand.wait()
        recording = feltwire.read(file)
    sample, account = recording["/hand/sample"], recording["/hand/account"]
    print(f"{len(sample)} ticks of {recording.about['device']} in scene {recording.about['scene']}")

    depth, force = -sample["position"][:, 2], sample["held"][:, 2]  # [m], [N]
    pressed = (depth > 0.5e-3) & (sample["time"] < 2.9)  # At the end of the run the force fades.
    if pressed.any():
        stiffness = (force[pressed] @ depth[pressed]) / (depth[pressed] @ depth[pressed])  # least squares
        print(f"largest force {force.max():.2f} N, stiffness {stiffness:.0f} N/m (the scene says 600)")
    print(f"smallest balance of the account {1e3 * numpy.nanmin(account['balance']):.3f} mJ")
    reasons, counts = numpy.unique(account.names("no_force"), return_counts=True)
    print("ticks by the reason for no force:", dict(zip(reasons.tolist(), counts.tolist())))
    if len(sys.argv) > 1:
        feltwire.plot(recording, sys.argv[1])


if __name__ == "__main__":
    main()

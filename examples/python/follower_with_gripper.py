#!/usr/bin/env python3
"""A robot with a gripper, in Python, and a hand that leads it: follower_with_gripper.py [SECONDS]

The robot is a point of 2 kg that an impedance controller draws to its target, over a table of 2 kN/m. Replace Robot by calls of the
maker's library. Its loop runs in a thread, 500 times a second. The hand presses its enabling switch, goes down until the robot presses the
table, and closes the gripper. A real hand would be one of feltwire's drivers, in a program of its own.
"""
import pathlib
import sys
import threading
import time

import feltwire

SEAT = pathlib.Path(__file__).resolve().parents[2] / "scenes/teleoperation/seat.json"
RATE = 500  # [Hz] of the robot's own loop
STEP = 1e-4  # [s] of its physics


class Robot:
    """Positions [m], forces [N]; z is up, the table is at z = 0."""

    MASS, STIFFNESS, DAMPING, TABLE, OPEN = 2.0, 1000.0, 90.0, 2000.0, 0.08

    def __init__(self):
        self.position, self.velocity, self.force = [0.0, 0.0, 0.01], [0.0] * 3, [0.0] * 3
        self.target, self.gripper = list(self.position), self.OPEN

    def move(self, seconds):
        for _ in range(max(1, round(min(seconds, 0.05) / STEP))):
            self.force[2] = max(0.0, -self.TABLE * self.position[2])
            for i in range(3):
                pull = self.STIFFNESS * (self.target[i] - self.position[i]) - self.DAMPING * self.velocity[i] + self.force[i]
                self.velocity[i] += STEP * pull / self.MASS
                self.position[i] += STEP * self.velocity[i]


def run(robot, follower):
    last = time.monotonic()
    for _ in follower.paced(RATE):
        now = time.monotonic()
        robot.move(now - last)
        last = now
        target = follower.exchange(robot.position, velocity=robot.velocity, force=robot.force, gripper=robot.gripper)
        if target is None:  # the run has ended: the robot stays
            return
        robot.target, robot.gripper = list(target.position), target.gripper


def main(seconds):
    robot = Robot()
    with feltwire.serve(SEAT) as server:
        with server.follow(stiffness=robot.STIFFNESS, damping=robot.DAMPING, mass=robot.MASS, gripper_opening=robot.OPEN) as follower:
            thread = threading.Thread(target=run, args=(robot, follower))
            thread.start()
            with server.join(device="caller:await_still=0", lead=0.2, rate=200) as hand:
                height, felt, begin = 0.3, 0.0, time.monotonic()
                while (passed := time.monotonic() - begin) < seconds:
                    engaged = follower.state == "engaged"
                    height -= 0.00015 if engaged and height > 0.27 else 0.0
                    # The switch must be seen released first.
                    given = hand.exchange((0.0, 0.0, height), deadman=passed > 0.5, gripper=robot.OPEN / 2 if engaged else robot.OPEN)
                    felt = max(felt, given[0][2]) if given else felt
                    time.sleep(0.005)
                print(f"the robot is {follower.state}, at z = {1e3 * robot.position[2]:.1f} mm, and presses with {robot.force[2]:.1f} N")
                print(f"its gripper is open by {1e3 * robot.gripper:.0f} mm; the hand felt at most {felt:.2f} N")
            follower.stop()
            thread.join()


if __name__ == "__main__":
    main(float(sys.argv[1]) if len(sys.argv) > 1 else 4.0)

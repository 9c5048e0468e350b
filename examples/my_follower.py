#!/usr/bin/env python3
"""A robot of one's own as a follower, in Python, with the standard library only (docs/followers.md).

    my_follower.py SOCKET [SECONDS]

The robot here is a point of 2 kg that an impedance controller draws to its target, above a floor of 2 kN/m. Replace Robot by
calls of the maker's library. It sends 200 states a second and obeys the newest target that is there. Where none comes, or the
other side says hold, it stays at the target that it has: there is nothing that would have to be stopped.
"""

import select
import socket
import sys
import time

RATE = 200  # [1/s]
LONGEST = 0.1  # [s] that a state may take to be sent
STEPS = 20  # of physics in a state


class Robot:
    """Positions [m], velocities [m/s], forces [N]; z is up, the floor is at z = 0."""

    MASS, STIFFNESS, DAMPING, FLOOR = 2.0, 1000.0, 90.0, 2000.0

    def __init__(self):
        self.position, self.velocity, self.force = [0.0, 0.0, 0.1], [0.0] * 3, [0.0] * 3
        self.target, self.gripper = list(self.position), 0.0

    def move(self, seconds):
        step = seconds / STEPS
        for _ in range(STEPS):
            self.force = [0.0, 0.0, max(0.0, -self.FLOOR * self.position[2])]
            for i in range(3):
                pull = self.STIFFNESS * (self.target[i] - self.position[i]) + self.force[i]
                self.velocity[i] = (self.velocity[i] + step * pull / self.MASS) / (1 + step * self.DAMPING / self.MASS)
                self.position[i] += step * self.velocity[i]


def listed(values):
    return ",".join(f"{v:.9g}" for v in values)


def fields(words):
    return dict(word.split("=", 1) for word in words)


class Driver:
    def __init__(self, path, robot):
        self.robot, self.rest, self.holds = robot, b"", False
        self.socket = socket.socket(socket.AF_UNIX, socket.SOCK_STREAM)
        self.socket.settimeout(LONGEST)
        self.socket.connect(path)
        self.send(f"follower 1 name=my_follower period={1 / RATE} stiffness={robot.STIFFNESS} damping={robot.DAMPING} "
                  f"mass={robot.MASS} own_damping=3 wrench_noise=0.01 gripper=0.08")

    def send(self, line):
        self.socket.sendall(line.encode() + b"\n")

    def lines(self):
        """All whole lines that have come."""
        if select.select([self.socket], [], [], 0)[0]:
            got = self.socket.recv(65536)
            if not got:
                raise SystemExit("my_follower: the other side hung up")
            self.rest += got
        *whole, self.rest = self.rest.split(b"\n")
        return [line.decode() for line in whole if line]

    def obey(self):
        target = None
        for line in self.lines():
            kind, *words = line.split(" ")
            if kind == "target":
                target = fields(words[1:])
            elif kind == "hold":
                self.holds = True
            elif kind == "error":
                print(f"my_follower: {line}", file=sys.stderr)
        # Only the newest counts; one that comes after hold does not.
        if target and not self.holds:
            self.robot.target = [float(v) for v in target["pose"].split(",")[:3]]
            self.robot.gripper = float(target["gripper"])

    def say(self, number):
        r = self.robot
        upright = "1,0,0,0"  # this robot does not turn
        self.send(f"state {number} pose={listed(r.position)},{upright} velocity={listed(r.velocity)} force={listed(r.force)} "
                  f"commanded={listed(r.target)},{upright} gripper={max(0.0, r.gripper):.9g} ok=1 stopped={int(self.holds)}")


def main():
    if len(sys.argv) not in (2, 3):
        raise SystemExit(__doc__)
    until = time.monotonic() + float(sys.argv[2]) if len(sys.argv) == 3 else float("inf")
    robot = Robot()
    driver = Driver(sys.argv[1], robot)
    number, due = 0, time.monotonic()
    while due < until:
        number, due = number + 1, due + 1 / RATE
        driver.obey()
        robot.move(1 / RATE)
        driver.say(number)
        time.sleep(max(0.0, due - time.monotonic()))


if __name__ == "__main__":
    try:
        main()
    except OSError as gone:
        raise SystemExit(f"my_follower: {gone}") from None

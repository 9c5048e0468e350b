"""Checks of a server: the seat of a robot, the hand that leads it, and the states between them (PROTOCOL.md, "A robot that follows")."""
import time

import flat
from checks import check, eventually, expect
from checks_control import refused
from control import join_request
from hand import Hand
from schema import DATAGRAM

SEAT = "seat"  # the scene
STATE, TARGET = 4, 5  # kinds
DISABLED, READY, ENGAGED, CLUTCHED, HOLD, FAULT = range(6)
PLACE, UPRIGHT = (0.1, 0.2, 0.3), (1.0, 0.0, 0.0, 0.0)
SILENCE = 0.1  # [s] after which the server goes to hold or fault
TRIES = 10


class Late(Exception):
    """This machine did not run the check for so long that the server must take it for silence."""


class Robot(Hand):
    """A robot that stands still, whatever its target is."""

    def __init__(self, server):
        super().__init__(server, scene=SEAT, role="follower", control=server.control("follower"))
        self.told = 0.0

    def tell_state(self, index=None, flags=3):
        self.index += index is None
        state = {"index": self.index if index is None else index, "time": time.monotonic_ns(), "position": PLACE, "orientation": UPRIGHT,
                 "commanded": PLACE, "commanded_turn": UPRIGHT, "flags": flags}
        self.send(self.seal(flat.write(DATAGRAM, "FollowerState", {"state": state}), kind=STATE))

    def read(self, datagram):
        """The target of a datagram of the server."""
        payload = self.down.open(datagram)
        expect(datagram[3] == TARGET and payload is not None, f"kind {datagram[3]} for a robot")
        return flat.read(DATAGRAM, "FollowerTarget", payload).target

    def newest(self, sample):
        """The target that comes of a hand's sample."""
        end = time.monotonic() + 1
        while time.monotonic() < end:
            datagram = self.datagram(0.2)
            if datagram is not None and (target := self.read(datagram)).sample_index >= sample:
                return target
        raise Late()


class Pair:
    """A robot and a hand that leads it."""

    def __init__(self, server):
        self.robot, self.hand, self.when = Robot(server), Hand(server, scene=SEAT), None

    def lead(self, pressed, x=0.0, timely=True):
        """(state, the robot's target) behind a sample of the hand, with a new state of the robot before it."""
        self.robot.tell_state()
        self.robot.datagram(0.0)
        remote = self.hand.ask((x, 0.0, 0.1), lead={"gripper": -1.0, "flags": int(pressed)}).remote
        expect(remote is not None, "a reply to a lead has no remote")
        target = self.robot.newest(self.hand.index)
        now = time.monotonic()
        if timely and self.when is not None and now - self.when > 0.6 * SILENCE:
            raise Late()
        self.when = now
        expect(target.state & 255 == remote.state & 255, f"state {remote.state} for the hand, {target.state} for the robot")
        return remote.state & 255, (target.position.x, target.position.y, target.position.z)

    def close(self):
        self.hand.close()
        self.robot.close()


def with_pair(function):
    """Gives the check a robot and a hand, anew where this machine was late."""
    def run(server):
        for _ in range(TRIES):
            pair = Pair(server)
            try:
                return function(server, pair)
            except Late:
                continue
            finally:
                pair.close()
        return f"inconclusive: this machine was late by more than {SILENCE} s in {TRIES} tries"
    return run


def near(place, x):
    return all(abs(a - b) < 1e-6 for a, b in zip(place, (PLACE[0] + x, PLACE[1], PLACE[2])))


@check("S-500", "such a token is of one scene and opens the robot's seat there, nothing else opens it, and it is refused `not_supported` where the "
       "scene has none, `full` while another robot sits there.", "robots")
def followers(server):
    elsewhere = server.control("follower_elsewhere")
    role = server.role_number("follower")
    robot = Robot(server)
    try:
        refused("not_supported", elsewhere, "JoinRequest", **join_request(server.scene, role=role))
        second = server.control("follower")
        refused("full", second, "JoinRequest", **join_request(SEAT, role=role))
        refused("forbidden", second, "JoinRequest", **join_request(SEAT))
        refused("forbidden", second, "ListSessions")
        second.close()
        other = server.control("operator")
        refused("forbidden", other, "JoinRequest", **join_request(SEAT, role=role))
        other.close()
        for _ in range(3):
            robot.tell_state()
            time.sleep(0.011)
        target = robot.read(robot.datagram())
        expect(target.index >= 1 and target.state == DISABLED and target.reserved == 0, f"{target}")
    finally:
        robot.close()
        elsewhere.close()
    return "not_supported without a seat, full beside another robot, forbidden for other roles; its states are answered by a target, disabled"


@check("S-501", "stays disabled: never engages", "robots")
@with_pair
def never_released(server, pair):
    states = [pair.lead(True)[0] for _ in range(10)]
    expect(states == [DISABLED] * 10, f"states {states} with a switch that was never released")
    expect(pair.lead(False)[0] == READY, "a released switch does not make it ready")
    expect(pair.lead(True)[0] == ENGAGED, "a pressed switch does not engage")
    return "a pressed switch engages only after a released one"


@check("S-502", "At each engagement the hand's place (less its offset) corresponds to the robot's present target: the first step of the target is "
       "exactly zero, at any pose and scale.", "robots")
@with_pair
def first_step(server, pair):
    pair.lead(False, 0.05)
    state, place = pair.lead(True, 0.05)
    expect(state == ENGAGED and near(place, 0.0), f"state {state}, target {place}")
    state, place = pair.lead(True, 0.0505)
    expect(state == ENGAGED and near(place, 0.0005), f"a movement of 0.5 mm gives the target {place}")
    return "the target is the robot's place at the engagement, and moves with the hand from there"


@check("S-503", "The target moves only in `engaged`.", "robots")
@with_pair
def moves_engaged(server, pair):
    pair.lead(False)
    pair.lead(True)
    state, place = pair.lead(False, 0.0)
    expect(state == CLUTCHED, f"state {state} after a released switch")
    for x in (0.0005, 0.001):
        state, moved = pair.lead(False, x)
        expect(state == CLUTCHED and moved == place, f"state {state}: the target moved from {place} to {moved}")
    state, moved = pair.lead(True, 0.001)
    expect(state == ENGAGED and moved == place, f"state {state}: the target moved from {place} to {moved} at the engagement")
    return "a hand that moves with a released switch moves no target; nor does the next engagement"


@check("S-504", "no sample of the hand for 0.1 s; the hand jumped by more than 5 times the speed limit; the robot's force passed its limit",
       "robots")
@with_pair
def hold(server, pair):
    pair.lead(False)
    begin = time.monotonic()
    expect(pair.lead(True)[0] == ENGAGED, "not engaged")

    def silent():
        pair.robot.tell_state()
        datagram = pair.robot.datagram(0.02)
        return datagram is not None and pair.robot.read(datagram).state & 255 == HOLD
    eventually(silent, "hold without a sample of the hand")
    took = time.monotonic() - begin
    expect(pair.lead(True, timely=False)[0] == HOLD, "a pressed switch ends hold")
    expect(pair.lead(False)[0] == READY, "a released switch does not end hold")
    expect(pair.lead(True)[0] == ENGAGED, "not engaged")
    expect(pair.lead(True, 0.05)[0] == HOLD, "no hold after a jump of 50 mm")
    expect(pair.lead(True, 0.05)[0] == HOLD, "a pressed switch ends hold")
    expect(pair.lead(False, 0.05)[0] == READY, "a released switch does not end hold")
    expect(took >= SILENCE, f"hold after {took:.3f} s")
    return f"hold {took:.2f} s after the last sample, and after a jump; only a released switch ends it"


@check("S-505", "no state of the robot for 0.1 s; the robot reports that it is stopped or not well", "robots")
@with_pair
def fault(server, pair):
    pair.lead(False)
    expect(pair.lead(True)[0] == ENGAGED, "not engaged")

    def silent():
        return pair.hand.ask((0.0, 0.0, 0.1), lead={"gripper": -1.0, "flags": 1}).remote.state & 255 == FAULT
    eventually(silent, "fault without a state of the robot")
    expect(pair.lead(True, timely=False)[0] == FAULT, "fault ended while the switch is pressed")
    expect(pair.lead(False)[0] == READY, "the robot is well and the switch released: not ready")
    expect(pair.lead(True)[0] == ENGAGED, "not engaged")
    for flags in (1, 7):  # not well; a protective stop
        pair.robot.tell_state(flags=flags)
        state = pair.hand.ask((0.0, 0.0, 0.1), lead={"gripper": -1.0, "flags": 1}).remote.state & 255
        expect(state == FAULT, f"state {state} after the robot's flags {flags}")
        pair.lead(False, timely=False)
        pair.lead(True, timely=False)
    return "fault without states, when the robot is not well and when it is stopped; then a released switch"


@check("S-506", "Others that send a `lead` wait, 8 of them at most, and get the state disabled.", "robots")
@with_pair
def others_wait(server, pair):
    other, pointer = Hand(server, scene=SEAT), Hand(server, scene=SEAT, role="pointer", device={"max_force": 5.0})
    try:
        pair.lead(False)
        expect(pair.lead(True)[0] == ENGAGED, "not engaged")
        states = [other.ask(lead={"gripper": -1.0, "flags": flags}).remote.state & 255 for flags in (0, 1)]
        if time.monotonic() - pair.when > 0.6 * SILENCE:
            raise Late()  # the lead may have been handed over
        expect(states == [DISABLED, DISABLED], f"states {states} of a second hand")
        expect(pointer.ask(lead={"gripper": -1.0}).remote is None, "a pointer's lead is answered with a remote")
        expect(other.ask().remote is None, "a reply to a sample without a lead has a remote")
        expect(pair.lead(True)[0] == ENGAGED, "the second hand's switch took the lead from one that holds it")
    finally:
        other.close()
        pointer.close()
    return "a second hand is disabled while the first holds its switch; a pointer's lead is ignored"


@check("S-507", "counted by the follower from 1; one that is not newer is `stale`", "robots")
def stale_state(server):
    robot = Robot(server)
    watch = server.control("admin")

    def stale():
        return {one.name: one.value for one in watch.ask("GetCounters", scene=SEAT).counters}["dropped.stale"]
    try:
        robot.tell_state()
        robot.tell_state()
        before = stale()
        robot.tell_state(index=2)
        robot.tell_state(index=1)
        eventually(lambda: stale() == before + 2, "two states that are not newer are counted as stale")
    finally:
        watch.close()
        robot.close()
    return "states with the indices 1, 2, 2, 1: the last two are stale"

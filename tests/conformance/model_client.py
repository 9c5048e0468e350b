#!/usr/bin/env python3
"""A client in Python, made from PROTOCOL.md: joins, sends samples of a hand that slides, holds and fades what is commanded.

It takes the options of feltwire-client that the checks use. `--wrong NAME` makes it a mutant (mutants.py).
"""
import argparse
import math
import select
import socket
import sys
import time

sys.dont_write_bytecode = True
import flat  # noqa: E402
import openssl  # noqa: E402
import sealing  # noqa: E402
from control import DEVICE, Control, Refused, join_request  # noqa: E402
from grants import wrong_grant  # noqa: E402
from schema import DATAGRAM  # noqa: E402

HEALING = ("full", "shutting_down", "too_many", "failed")
MOST_FORCE = 8.0  # [N] of the device
WINDOW = 1024
POSITIONS = 1000.0  # [m]


class Final(Exception):
    """An error that a retry cannot repair."""


class Dropped(Exception):
    pass


class Address:
    def __init__(self, text, fingerprint):
        self.host, port = text.rsplit(":", 1)
        self.port, self.fingerprint = int(port), fingerprint


class Gate:
    """What a client checks of a server's datagrams."""

    def __init__(self, session, down, wrong):
        self.session, self.down, self.wrong = session, down, wrong
        self.highest, self.seen, self.sent, self.answered = 0, set(), set(), 0

    def take(self, datagram):
        """(kind, table) of a datagram that passes."""
        wrong = self.wrong
        if not 40 <= len(datagram) <= 1200:
            raise Dropped("size")
        head = sealing.Head(datagram)
        if head.magic != b"FW" or (head.version != 1 and wrong != "any_version") or head.kind not in (2, 3):
            raise Dropped("header")
        if (head.reserved != 0 and wrong != "any_reserved") or (head.session != self.session and wrong != "any_session"):
            raise Dropped("header")
        if head.packet == 0 or (head.packet in self.seen and wrong != "replay_taken") or head.packet + WINDOW <= self.highest:
            raise Dropped("packet_number")
        if abs((head.packet >> 22) - (self.highest >> 22)) > 1:
            raise Dropped("sealed")
        payload = datagram[24:-16] if wrong == "unsealed_taken" else self.down.open(datagram)
        if payload is None and wrong == "goodbye_unsealed_taken" and head.kind == 3:
            payload = datagram[24:-16]
        if payload is None:
            if wrong == "number_of_forged":
                self.seen.add(head.packet)
            raise Dropped("sealed")
        self.seen.add(head.packet)
        self.highest = max(self.highest, head.packet)
        try:
            table = flat.read(DATAGRAM, "Reply" if head.kind == 2 else "Goodbye", payload)
        except flat.Malformed as error:
            raise Dropped("malformed") from error
        if head.kind == 3:
            if table.reason > 5 and wrong != "any_reason":
                raise Dropped("malformed")
            return head.kind, table
        self.check_reply(table)
        return head.kind, table

    def check_reply(self, table):
        wrong = self.wrong
        if table.sample_index == 0:
            raise Dropped("order")
        numbers = [*table.elastic.values(), *table.frictional.values()]
        if not all(map(math.isfinite, numbers)) and wrong != "nan_taken":
            raise Dropped("not_finite")
        if any(abs(number) > 1e12 for number in numbers) and wrong != "huge_taken":
            raise Dropped("not_finite")
        if table.sample_index not in self.sent and wrong != "never_sent_taken":
            raise Dropped("stale")
        if table.sample_index <= self.answered and wrong != "stale_taken":
            raise Dropped("stale")
        self.answered = max(self.answered, table.sample_index) if table.sample_index in self.sent else self.answered





class Force:
    """The command, and what of it is held by its age."""

    def __init__(self, hold, wrong):
        self.hold = hold * (2 if wrong == "holds_longer" else 1)
        self.wrong, self.command, self.arrived, self.share, self.last = wrong, (0.0, 0.0, 0.0), None, 0.0, None

    def set(self, command, now):
        size = math.sqrt(sum(part * part for part in command))
        scale = 1.0 if not size > MOST_FORCE else MOST_FORCE / size
        self.command, self.arrived = tuple(part * scale for part in command), now

    def held(self, now):
        age = math.inf if self.arrived is None else now - self.arrived
        half = self.hold / 2
        share = 1.0 if age < half else max(0.0, 1 - (age - half) / half)
        if self.wrong == "never_fades" and self.arrived is not None:
            share = 1.0
        if self.wrong == "drops_at_half" and age >= half:
            share = 0.0
        if self.last is not None and self.share < 1 and self.arrived is not None and self.wrong != "comes_back_at_once":
            most = self.share + (now - self.last) / half
            share = min(share, most) if self.touched else share
        self.touched = self.arrived is not None
        self.share, self.last = share, now
        return tuple(part * share for part in self.command)

    touched = False


class Session:
    def __init__(self, address, control, joined, options, wrong):
        self.joined, self.options, self.wrong, self.session = joined, options, wrong, joined.session
        self.up, down = sealing.keys_of(control.tls, joined.session, joined.suite)
        if wrong == "keys_swapped":
            self.up, down = down, self.up
        self.gate = Gate(joined.session, down, wrong)
        self.to = (address.host, address.port + joined.port_offset)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.packet, self.index, self.force = 0, 0, Force(joined.parameters.hold_time, wrong)
        self.history, self.travelled = [], []

    def seal(self, kind, table, value):
        self.packet += 1
        packet = max(1, self.packet // 2) if self.wrong == "numbers_twice" else self.packet
        number = self.session ^ 1 if self.wrong == "other_session" else self.session
        head = sealing.header(kind, number, packet, reserved=1 if self.wrong == "reserved_set" else 0)
        payload = flat.write(DATAGRAM, table, value)
        nonce = bytes(4) + packet.to_bytes(8, "big") if self.wrong == "nonce_reversed" else None
        if kind == 3 and self.wrong == "says_goodbye_unsealed":
            return head + payload + bytes(16)
        return self.up.seal(head, payload, nonce)

    def send(self, datagram):
        self.socket.sendto(datagram, self.to)

    def receive(self):
        """Takes what has come. A goodbye's reason ends the session."""
        while select.select([self.socket], [], [], 0)[0]:
            try:
                kind, table = self.gate.take(self.socket.recv(65536))
            except Dropped:
                if self.wrong == "dropped_is_life":
                    self.alive = time.monotonic()
                continue
            if kind == 3:
                if self.wrong != "goodbye_ignored":
                    return table.reason
                continue
            self.alive = time.monotonic()
            self.force.set(tuple(table.elastic.values()), time.monotonic())
        return None

    def sample(self, now):
        self.index += 1
        index = max(1, self.index - self.index // 4) if self.wrong == "indices_twice" else self.index
        held = self.force.command if self.wrong == "reports_command" else self.force.held(now)
        place = (0.02 * math.sin(3 * now), 0.0, 2000.0 if self.wrong == "far_away" else 0.01)
        return {"index": index, "client_time": int(now * 1e9), "position": place, "held_elastic": held}

    def tell(self, parameters):
        """A datagram of the samples since the last one, and those that travelled before."""
        n, m = (1, 1) if self.wrong == "interval_ignored" else (parameters.packet_interval, parameters.batch)
        recent = self.history[-n:][::-1]
        fresh = [recent[place * n // m] for place in range(m) if place * n // m < len(recent)]
        again = self.travelled[:0 if self.wrong == "repeats_nothing" else parameters.redundancy]
        if self.wrong == "repeats_changed":
            again = [{**one, "held_elastic": (0.0, 0.0, 0.1)} for one in again]
        before = self.travelled[len(again)]["index"] if len(self.travelled) > len(again) else 0
        if self.wrong == "previous_zero":
            before = 0
        self.travelled = (fresh + self.travelled)[:20]
        self.gate.sent |= {one["index"] for one in fresh}
        value = {"samples": fresh + again, "previous": before}
        if self.index % 20 == 1:
            value["report"] = {"balance": math.nan if self.wrong == "report_not_finite" else 0.0}
        if self.wrong == "times_alone":
            value["times"] = {"wakeups": [0] * 8, "round_trips": [0] * 8}
        self.send(self.seal(sealing.SAMPLES, "Samples", value))

    def run(self, end):
        """Until the end of the run, a goodbye (its reason) or silence ("silence")."""
        parameters, period = self.joined.parameters, self.joined.parameters.servo_period
        self.alive = due = time.monotonic()
        leaving = None
        while True:
            reason = self.receive()
            now = time.monotonic()
            if reason is not None:
                return reason
            if now - self.alive > self.joined.silence_timeout and self.wrong != "never_lost":
                return "silence"
            if leaving is None and now >= end:
                leaving = now
                self.force.arrived = min(self.force.arrived or now, now - parameters.hold_time / 2)
            if leaving is not None and (now - leaving >= parameters.hold_time / 2 or self.wrong == "leaves_at_once"):
                break
            if leaving is not None:
                self.force.arrived = min(self.force.arrived or 0, leaving - parameters.hold_time / 2)
            self.history = [*self.history, self.sample(now)][-1000:]
            if self.index % (1 if self.wrong == "interval_ignored" else parameters.packet_interval) == 0 or self.index == 1:
                self.tell(parameters)
            due = max(due + period, now - period)
            time.sleep(max(0.0, due - time.monotonic()))
        if self.wrong != "leaves_silently":
            for _ in range(1 if self.wrong == "one_goodbye" else 3):
                self.send(self.seal(sealing.GOODBYE, "Goodbye", {"reason": 0}))
        return "end"


def join(address, options, wrong, before):
    """A session of a server that is trusted and whose grant is taken."""
    control = Control(address)
    if control.tls.fingerprint() != options.fingerprint and wrong != "pin_ignored":
        raise Final("fingerprint: the certificate is not the one that is trusted")
    parameters = {"mode": "none", "servo_period": 1 / options.rate, "hold_time": options.hold_time, "redundancy": options.redundancy}
    if before and wrong == "rejoins_otherwise":
        parameters["redundancy"] = 5
    token = options.token_file.read().strip() if not before else before
    request = join_request(options.scene, {**DEVICE, "max_force": MOST_FORCE}, parameters, **({"tool": options.tool} if options.tool else {}))
    if wrong == "no_device_name":
        request["device"]["name"] = "n" * 129
    if wrong == "joins_first":
        control.ask("JoinRequest", **request)
    control.ask("Authenticate", token=token)
    joined = control.ask("JoinRequest", **request)
    problem = None if wrong == "takes_any_grant" else wrong_grant(request, joined)
    if problem and not (wrong == "takes_longer_hold" and problem.startswith("hold_time")):
        raise Final(problem)
    return Session(address, control, joined, options, wrong), token


def main():
    parser = argparse.ArgumentParser(allow_abbrev=False)
    for name, kind, usual in (("connect", str, None), ("scene", str, "plane"), ("fingerprint", str, ""), ("token-file", open, None),
                              ("duration", float, 1), ("rate", float, 200), ("hold-time", float, 0.1), ("redundancy", int, 3),
                              ("reconnect", float, 30), ("tool", str, ""), ("wrong", str, "")):
        parser.add_argument("--" + name, type=kind, default=usual)
    options, _ = parser.parse_known_args()
    address, end, token, lost = Address(options.connect, options.fingerprint), time.monotonic() + options.duration, None, time.monotonic()
    while True:
        try:
            session, token = join(address, options, options.wrong, token)
        except (Final, Refused, OSError, openssl.Closed, openssl.Silent) as error:
            healing = not isinstance(error, Final) and getattr(error, "code", "full") in HEALING
            if (healing or options.wrong == "asks_again") and time.monotonic() - lost < options.reconnect:
                time.sleep(0.05)
                continue
            print(f"error: {error!r}", file=sys.stderr)
            return 1
        reason = session.run(end)
        if reason == "end":
            return 0
        lost = time.monotonic()
        if options.reconnect == 0 or options.wrong == "never_again":
            print(f"error: the session ended: {reason}", file=sys.stderr)
            return 1


if __name__ == "__main__":
    sys.exit(main())

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
import sealing  # noqa: E402
import tls13  # noqa: E402
from control import DEVICE, VERSIONS, Control, Refused, join_request  # noqa: E402
from grants import same, wrong_grant  # noqa: E402
from model_session import finite  # noqa: E402
from schema import DATAGRAM  # noqa: E402

HEALING = ("full", "shutting_down", "too_many", "failed", "bad_ticket")
MOST_FORCE = 8.0  # [N] of the device
WINDOW = 1024
POSITIONS = 1000.0  # [m]


class Final(Exception):
    """An error that a retry cannot repair."""


class Dropped(Exception):
    """A datagram fails the check of this name."""


class Address:
    """The host and the control port of a server."""

    def __init__(self, text):
        self.host, port = text.rsplit(":", 1)
        self.port = int(port)


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
        if head.packet == 0 or (head.packet in self.seen and wrong != "replay_taken") or (
                head.packet + WINDOW <= self.highest and wrong != "window_open"):
            raise Dropped("packet_number")
        generations = 0 if wrong == "one_generation" else 1
        if abs((head.packet >> 22) - (self.highest >> 22)) > generations:
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
        if (table.normals is not None and len(table.normals) not in (2, 3)) or (table.change and not 1 <= table.change.number <= 63):
            raise Dropped("count")
        if not finite(table) and wrong != "nan_taken":
            raise Dropped("not_finite")
        if any(abs(sum(part * part for part in normal.values()) - 1) > 1e-3 for normal in table.normals or []):
            raise Dropped("not_finite")
        if any(abs(part) > 1e12 for part in [*table.elastic.values(), *table.frictional.values()]) and wrong != "huge_taken":
            raise Dropped("not_finite")
        if table.sample_index not in self.sent and wrong != "never_sent_taken":
            raise Dropped("stale")
        if table.sample_index <= self.answered and wrong != "stale_taken":
            raise Dropped("stale")
        self.answered = max(self.answered, table.sample_index) if table.sample_index in self.sent else self.answered





class Force:
    """The command, how it changes by itself, and what of it is held by its age."""

    def __init__(self, parameters, small, wrong):
        self.small, self.waits = small, wrong != "never_waits"
        self.hold, self.keep_alive, self.wrong = parameters.hold_time * (2 if wrong == "holds_longer" else 1), parameters.keep_alive, wrong
        self.command, self.rate, self.since, self.arrived = (0.0, 0.0, 0.0), None, 0.0, None
        self.share, self.last = None, None

    def set(self, reply, now):
        command = tuple(reply.elastic.values())
        size = math.sqrt(sum(part * part for part in command))
        scale = 1.0 if not size > MOST_FORCE or self.wrong == "force_unlimited" else MOST_FORCE / size
        self.command, self.arrived, self.since = tuple(part * scale for part in command), now, reply.client_time / 1e9
        self.waits = self.waits and size > self.small
        self.rate = tuple(reply.rates.elastic.values()) if reply.rates else None

    def commanded(self, now):
        """The command at this time, by the rates of the reply."""
        if self.rate is None:
            return self.command
        passed = max(0.0, now - self.since)
        passed = passed if self.wrong == "rates_for_ever" else min(passed, self.keep_alive)
        product = sum(a * b for a, b in zip(self.command, self.rate))
        if product < 0 and self.wrong != "pulls":
            passed = min(passed, -sum(a * a for a in self.command) / product)
        return tuple(a + b * passed for a, b in zip(self.command, self.rate))

    def held(self, now):
        if self.arrived is None:
            return self.command
        age, half = now - self.arrived, self.hold / 2
        share = 1.0 if age < half else max(0.0, 1 - (age - half) / half)
        if self.wrong == "never_fades":
            share = 1.0
        if self.wrong == "drops_at_half" and age >= half:
            share = 0.0
        if share == 0 and self.wrong != "never_waits":
            self.waits = True
        if self.waits:
            share = 0.0
        if self.share is not None and self.wrong != "comes_back_at_once":
            share = min(share, self.share + (now - self.last) / half)
        self.share, self.last = share, now
        return tuple(part * share for part in self.commanded(now))


class Session:
    def __init__(self, address, control, joined, options, wrong):
        self.joined, self.options, self.wrong, self.session = joined, options, wrong, joined.session
        self.up, down = sealing.keys_of(joined)
        if wrong == "wrong_secret":
            self.up = sealing.Keys(joined.suite, bytes(sealing.SECRET))
        if wrong == "keys_swapped":
            self.up, down = down, self.up
        self.gate = Gate(joined.session, down, wrong)
        self.to = (address.host, address.port + joined.port_offset)
        self.socket = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        self.packet, self.index, self.force = 0, 0, Force(joined.parameters, options.wait_for_small_force, wrong)
        self.history, self.travelled, self.change = [], [], 0

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
                if self.wrong == "goodbye_answered":
                    self.send(self.seal(sealing.GOODBYE, "Goodbye", {"reason": 0}))
                if self.wrong != "goodbye_ignored":
                    return table.reason
                continue
            self.alive = time.monotonic()
            self.change = table.change.number if table.change else self.change
            self.force.set(table, time.monotonic())
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
            flags = self.change << 2 | (2 if self.change and self.wrong != "change_taken" else 0)
            value["report"] = {"balance": math.nan if self.wrong == "report_not_finite" else 0.0, "flags": flags}
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
    control = Control(address, version=tls13.TLS12 if wrong == "tls12" else tls13.TLS13)
    if control.tls.fingerprint() != options.fingerprint and wrong != "pin_ignored":
        raise Final("fingerprint: the certificate is not the one that is trusted")
    parameters = {"mode": "none", "servo_period": 1 / options.rate, "hold_time": options.hold_time, "redundancy": options.redundancy}
    if before and wrong == "rejoins_otherwise":
        parameters["redundancy"] = 5
    token, granted = options.token, before
    request = join_request(options.scene, {**DEVICE, "max_force": MOST_FORCE}, parameters, **({"tool": options.tool} if options.tool else {}))
    if wrong == "long_device_name":
        request["device"]["name"] = "n" * 129
    if wrong == "joins_first":
        control.ask("JoinRequest", **request)
    told = control.ask("Authenticate", token=token, **({} if wrong == "versions_unsaid" else VERSIONS))
    if not told.oldest_protocol <= VERSIONS["newest_protocol"] <= told.newest_protocol and wrong != "any_server_version":
        raise Final(f"the server speaks version {told.newest_protocol} of the protocol, this client version {VERSIONS['newest_protocol']}")
    joined = control.ask("JoinRequest", **request)
    if wrong == "always_aes":
        joined["suite"] = 1
    if wrong != "any_secret":
        for name in ("secret_up", "secret_down"):
            if len(joined[name] or []) != sealing.SECRET:
                raise Final(f"{name} has not {sealing.SECRET} bytes")
        if joined.secret_up == joined.secret_down:
            raise Final("secret_up and secret_down are equal")
    problem = None if wrong == "takes_any_grant" else wrong_grant(request, joined)
    taken = {"takes_longer_hold": "hold_time", "takes_any_tool": "tool"}.get(wrong)
    if problem and not (taken and problem.startswith(taken)):
        raise Final(problem)
    for name, value in joined.parameters.items():
        if granted and not same(granted[name], value) and wrong != "takes_other_parameters":
            raise Final(f"{name}: {granted[name]} was granted before, {value} now")
    return Session(address, control, joined, options, wrong), joined.parameters


def main():
    parser = argparse.ArgumentParser(allow_abbrev=False)
    for name, kind, usual in (("connect", str, None), ("scene", str, "plane"), ("fingerprint", str, ""), ("token-file", open, None),
                              ("duration", float, 1), ("rate", float, 200), ("hold-time", float, 0.1), ("redundancy", int, 3),
                              ("reconnect", float, 30), ("tool", str, ""), ("wait-for-small-force", float, 0.05), ("wrong", str, "")):
        parser.add_argument("--" + name, type=kind, default=usual)
    options, _ = parser.parse_known_args()
    options.token = options.token_file.read().strip()
    address, end, before, lost = Address(options.connect), time.monotonic() + options.duration, None, time.monotonic()
    while True:
        try:
            session, before = join(address, options, options.wrong, before)
        except (Final, Refused, OSError, tls13.Closed, tls13.Silent) as error:
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

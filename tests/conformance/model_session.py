"""A session of the model server: its keys, its window of packet numbers, its samples and its command, as the text has them.

The model feels one plane, z = 0 of 600 N/m. `wrong` holds the names of the deviations that a mutant has (mutants.py).
"""
import math
import struct
import time

import flat
import sealing
from schema import DATAGRAM

STIFFNESS = 600.0  # [N/m]
WINDOW = 1024
POSITIONS = 1000.0  # [m]
UNIT = 1e-3


class Dropped(Exception):
    """The datagram fails the check of this name."""


def finite(value):
    """All numbers of a table are finite."""
    if isinstance(value, dict):
        return all(finite(part) for part in value.values())
    if isinstance(value, (list, tuple)):
        return all(finite(part) for part in value)
    return not isinstance(value, float) or math.isfinite(value)


class Session:
    def __init__(self, number, client, role, parameters, keys, silence, wrong):
        self.number, self.client, self.role, self.parameters, self.silence, self.wrong = number, client, role, parameters, silence, wrong
        self.up, self.down = keys
        self.highest, self.seen, self.opened = 0, set(), False
        self.packet, self.newest, self.last = 0, 0, None
        self.address, self.address_packet = None, 0
        self.alive = time.monotonic()
        self.tokens = 1.5 / parameters["servo_period"]
        self.flood = 2 * self.tokens
        self.refilled = time.monotonic()
        self.changes, self.change, self.asked, self.taken, self.report, self.times, self.counts = 0, None, 0, 0, None, None, None
        self.energy, self.force, self.replied, self.withheld = [0.0, 0.0], None, 0.0, 0

    def check_number(self, packet):
        window = WINDOW - 1 if "window_short" in self.wrong else WINDOW
        seen = packet in self.seen and "replay_taken" not in self.wrong
        if packet == 0 or seen or packet + window <= self.highest:
            raise Dropped("packet_number")

    def open(self, datagram, packet):
        """The payload, by the keys that a receiver has."""
        generation, newest = packet >> 22, self.highest >> 22
        if abs(generation - newest) > 1 and "any_generation" not in self.wrong:
            raise Dropped("sealed")
        payload = self.up.open(datagram)
        if payload is None and "both_directions" in self.wrong:
            payload = self.down.open(datagram)
        if payload is None:
            if "number_of_forged" in self.wrong:
                self.keep_number(packet)
            raise Dropped("sealed")
        return payload

    def keep_number(self, packet):
        self.seen.add(packet)
        self.highest = max(self.highest, packet)

    def check_rate(self, count):
        """Takes tokens for new samples. True: the session has to end."""
        now, rate = time.monotonic(), 1.5 / self.parameters["servo_period"]
        passed, self.refilled = now - self.refilled, now
        self.tokens = min(rate, self.tokens + rate * passed)
        self.flood = min(2 * rate, self.flood + 2 * rate * passed)
        self.flood -= count
        if self.flood < 0 and "flood_taken" not in self.wrong:
            return True
        if self.tokens < 1 and "rate_unlimited" not in self.wrong:
            raise Dropped("rate")
        self.tokens -= 1 if "datagrams_counted" in self.wrong else count
        return False

    def check_samples(self, table):
        """The checks `count` to `stale` of the text."""
        samples, rotations = table.samples, table.rotations
        least, most = 0 if "no_sample_taken" in self.wrong else 1, 10 if "ten_samples" in self.wrong else 9
        if not least <= len(samples) <= most or (rotations is not None and len(rotations) != len(samples)):
            raise Dropped("count")
        indices = [one["index"] for one in samples]
        falling = all(a > b for a, b in zip(indices, indices[1:]))
        if (0 in indices or not falling or table.previous >= min(indices, default=1)) and "order_ignored" not in self.wrong:
            raise Dropped("order")
        norms = [sum(part * part for part in one["orientation"].values()) for one in rotations or []]
        limit = 2 * POSITIONS if "far_taken" in self.wrong else POSITIONS
        far = any(abs(part) > limit for one in samples for part in one["position"].values())
        if not finite(table) or far or any(abs(norm - 1) > UNIT for norm in norms):
            raise Dropped("not_finite")
        if max(indices, default=0) <= self.newest and "stale_taken" not in self.wrong:
            raise Dropped("stale")

    def take(self, table):
        """Takes the new samples, the oldest first; (how many, a gap, how many are missing)."""
        fresh = [one for one in table.samples[::-1] if one["index"] > self.newest or "repeated_taken" in self.wrong]
        gap = missing = 0
        for one in fresh:
            step = one["index"] - self.newest
            if (self.last is not None or "first_moves" in self.wrong) and step > 1 and one is fresh[0]:
                gap = 1 if table.previous > self.newest or "gap_always" in self.wrong else 0
                missing = step - 1
            if self.last is not None:
                way = [one["position"][axis] - self.last["position"][axis] for axis in "xyz"]
                for part, held in enumerate(("held_elastic", "held_frictional")):
                    force = (one if "held_of_the_newer" in self.wrong else self.last)[held]
                    self.energy[part] += sum(force[axis] * moved for axis, moved in zip("xyz", way))
            self.last, self.newest = one, one["index"]
        self.taken += len(fresh)
        return len(fresh), gap, missing

    def tell(self, report, times):
        """Takes what the client says of itself."""
        self.report = report or self.report
        if self.change and report and ((report.flags >> 2 & 63) == self.change["number"] or "any_number_acknowledges" in self.wrong):
            self.change = None
        if times:
            before, self.counts = self.counts or times, times
            first = "times_from_zero" in self.wrong and self.times is None
            so_far = self.times or {name: [0] * 8 for name in times}
            self.times = {name: [a + (new if first else (new - old) % 65536) for a, new, old in zip(so_far[name], times[name], before[name])]
                          for name in times}

    def ask_change(self, wish):
        """Asks the client for a change; what an older one wanted and this one does not say stays."""
        self.asked = self.asked % 63 + ("numbers_stand" not in self.wrong or self.asked == 0)
        self.change = {**(self.change or {}), **wish, "number": self.asked}

    def local_model(self):
        """The plane as the one patch of a LocalModel."""
        place = self.last["position"]
        touching = 1 if place["z"] < 0 or "always_touching" in self.wrong else 0
        patch = {"point": (0.0, 0.0, -place["z"]), "normal": (0.0, 0.0, 1.0), "radius": 1.0, "stiffness": STIFFNESS, "feature": 1,
                 "flags": touching}
        return {"center": tuple(place.values()), "reach": 1.0, "patches": [patch], "scene": 1}

    def command(self, stiffness):
        depth = max(0.0, -self.last["position"]["z"])
        stiffness *= 2 if "twice_as_stiff" in self.wrong else 1
        return (0.0, 0.0, 0.0 if self.role == "observer" and "observer_pushed" not in self.wrong else stiffness * depth)

    def withholds(self, force, gap):
        band = self.parameters["force_deadband"]
        if not band or gap or self.force is None or "always_answers" in self.wrong:
            return False
        late = time.monotonic() - self.replied >= self.parameters["keep_alive"]
        change = abs(force[2] - self.force[2])
        return not late and change <= band * abs(force[2]) + 0.01 and (force[2] == 0) == (self.force[2] == 0)

    def seal(self, kind, payload):
        """A datagram with the next packet number."""
        self.packet += 1
        packet = max(1, self.packet - 1) if "number_repeated" in self.wrong else self.packet
        head = sealing.header(kind, self.number ^ 1 if "other_session" in self.wrong else self.number, packet)
        if kind == sealing.GOODBYE and "goodbye_unsealed" in self.wrong:
            return head + payload + bytes(16)
        nonce = bytes(4) + struct.pack(">Q", packet) if "nonce_reversed" in self.wrong else None
        return (self.up if "keys_swapped" in self.wrong else self.down).seal(head, payload, nonce)

    def reply(self, force, gap, received, view=None, **more):
        """The datagram that answers the newest sample."""
        self.force, self.replied = force, time.monotonic()
        flags = (8 if gap else 0) | (self.changes & 255) << 8 | (2 if "flag_of_bound" in self.wrong else 0)
        report = {"delivered_elastic": self.energy[0], "delivered_frictional": self.energy[1], "ratio": 1.0, "flags": flags}
        table = {"sample_index": self.newest, "client_time": self.last["client_time"], "server_receive_time": received,
                 "server_send_time": received, "elastic": force, "frictional": (0.0, 0.0, 0.0), "report": report,
                 "withheld": self.withheld, "view": view, "change": self.change, **more}
        if self.parameters["local_model"] and self.role != "observer":
            table["model"] = self.local_model()
        if "change_once" in self.wrong:
            self.change = None
        if "clock_stands" in self.wrong:
            table["server_receive_time"] = table["server_send_time"] = 1
        if "oldest_echoed" in self.wrong:
            table["sample_index"] = max(1, self.newest - 1)
        return self.seal(sealing.REPLY, flat.write(DATAGRAM, "Reply", table) + bytes(100 if "long_replies" in self.wrong else 0))

    def goodbye(self, reason):
        number = DATAGRAM.enums["GoodbyeReason"].values["leaving" if "wrong_reason" in self.wrong else reason]
        return self.seal(sealing.GOODBYE, flat.write(DATAGRAM, "Goodbye", {"reason": number}))

"""Datagrams that a client must drop. Each replies with a force of its own along x, or says goodbye, so that it shows if one was taken."""
import math
import struct

import flat
import sealing
from schema import DATAGRAM

MARGIN = 8  # packet numbers that may not have come yet
FIRST, STEP = 0.4, 0.05  # [N] along x: the force of the kinds by their place in KINDS


def reply(session, table, force, **fields):
    """The payload of a reply to the newest sample of a datagram."""
    newest = table.samples[0]
    value = {"sample_index": newest.index, "client_time": newest.client_time, "server_receive_time": 1, "server_send_time": 1,
             "elastic": (force, 0.0, 0.0), "frictional": (0.0, 0.0, 0.0), "report": {"ratio": 1.0}, **fields}
    return flat.write(DATAGRAM, "Reply", value)


def sealed(session, payload, kind=sealing.REPLY, number=None, packet=None, **head):
    if packet is None:
        session.packet += 1
        packet = session.packet
    return session.down.seal(sealing.header(kind, number or session.number, packet, **head), payload)


def with_header(**head):
    return lambda session, table, force: sealed(session, reply(session, table, force), **head)


def other_session(session, table, force):
    return sealed(session, reply(session, table, force), number=session.number ^ 1)


def used_number(session, table, force):
    return sealed(session, reply(session, table, force), packet=session.packet)


def behind_window(session, table, force):
    session.packet += 1  # so that none of these numbers is used twice
    return sealed(session, reply(session, table, force), packet=session.packet - 1024 - MARGIN)


def zero_number(session, table, force):
    return sealed(session, reply(session, table, force), packet=0)


def later_generation(session, table, force):
    return sealed(session, reply(session, table, force), packet=session.packet + 2 * sealing.GENERATION)


def damaged(session, table, force):
    data = bytearray(sealed(session, reply(session, table, force)))
    data[-1] ^= 1
    return bytes(data)


def not_sealed(session, table, force):
    session.packet += 1
    return sealing.header(sealing.REPLY, session.number, session.packet) + reply(session, table, force) + bytes(16)


def keys_of_the_client(session, table, force):
    session.packet += 1
    return session.up.seal(sealing.header(sealing.REPLY, session.number, session.packet), reply(session, table, force))


def shifted(session, table, force):
    """Numbers of 8 bytes lie at a multiple of 4 only."""
    good = reply(session, table, force)
    return sealed(session, struct.pack("<I", struct.unpack_from("<I", good)[0] + 4) + bytes(4) + good[4:])


def of(**fields):
    """A reply with these fields."""
    return lambda session, table, force: sealed(session, reply(session, table, force, **fields))


def of_sample(shift):
    def make(session, table, force):
        return sealed(session, reply(session, table, force, sample_index=table.samples[0].index + shift))
    return make


def huge(session, table, force):
    return sealed(session, reply(session, table, 1.1e12))


def goodbye(forge):
    def make(session, table, force):
        session.packet += 1
        payload = flat.write(DATAGRAM, "Goodbye", {"reason": 6 if forge == "reason" else 1})
        head = sealing.header(sealing.GOODBYE, session.number, session.packet)
        return head + payload + bytes(16) if forge == "seal" else session.down.seal(head, payload)
    return make


KINDS = {
    "magic": with_header(magic=b"WF"), "version": with_header(version=2), "kind 1": with_header(kind=1), "kind 5": with_header(kind=5),
    "reserved": with_header(reserved=1), "session": other_session, "packet number 0": zero_number, "packet number used": used_number,
    "packet number behind the window": behind_window, "generation after the next": later_generation, "tag": damaged, "no seal": not_sealed,
    "keys of the client": keys_of_the_client, "alignment": shifted, "one normal": of(normals=[(0.0, 0.0, 1.0)]),
    "change 64": of(change={"number": 64}), "sample 0": of(sample_index=0), "NaN force": of(frictional=(0.0, math.nan, 0.0)),
    "infinite ratio": of(report={"ratio": math.inf}), "normals not unit": of(normals=[(0.0, 0.0, 1.1), (0.0, 1.0, 0.0)]),
    "answered sample": of_sample(0), "older sample": of_sample(-1), "sample never sent": of_sample(1000), "1.1e12 N": huge,
    "goodbye without a seal": goodbye("seal"), "goodbye for an unknown reason": goodbye("reason"),
}


# Replies to a sample that was answered come behind the good reply. All others come before it, too, where nothing else speaks against them.
BEHIND_ONLY = ("answered sample", "older sample")


def around(name, session, table, good):
    """The datagrams of an answer: the good reply, made by `good`, and those of this kind before and behind it."""
    force = force_of(name)
    before = [] if name in BEHIND_ONLY else [KINDS[name](session, table, force)]
    return [*before, good(), KINDS[name](session, table, force)]


def force_of(name):
    return FIRST + STEP * list(KINDS).index(name)


def kind_of(force):
    """The kind whose force is held; the largest force of a device is that of `huge`."""
    place = round((force - FIRST) / STEP)
    names = list(KINDS)
    if force > force_of(names[-1]):
        return "1.1e12 N"
    return names[place] if 0 <= place < len(names) and abs(force - FIRST - STEP * place) < STEP / 10 else f"{force} N of one that fades"

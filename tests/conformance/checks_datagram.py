"""Checks of a server: what it drops, in which order, and under which name (PROTOCOL.md, "What a receiver checks")."""
import math
import struct

import flat
import sealing
from checks import check, eventually, expect
from hand import Hand
from schema import DATAGRAM

NAMES = ("size", "magic", "version", "kind", "reserved", "session", "packet_number", "sealed", "rate", "malformed", "count", "order",
         "not_finite", "stale")


def counters(server):
    """The counters of the server's scene, asked for by an admin."""
    if getattr(server, "watch", None) is None:
        server.watch = server.control("admin")
    return {one.name: one.value for one in server.watch.ask("GetCounters", scene=server.scene).counters}


def drops(server):
    values = counters(server)
    return {name: values.get(f"dropped.{name}") for name in NAMES}


def expect_dropped(server, hand, datagrams, name, count=None):
    """The server counts the datagrams under this name alone and answers none. The sample sent behind them is answered."""
    before = drops(server)
    for datagram in datagrams:
        hand.send(datagram)
    hand.send(hand.tell())
    answer = hand.reply()
    expect(answer is not None, f"{name}: a good datagram behind it was not answered")
    head, reply = answer
    expect(head.kind == sealing.REPLY and reply.sample_index == hand.index,
           f"{name}: it was answered: kind {head.kind}, {dict(reply) if head.kind != 2 else reply.sample_index}")
    wanted = len(datagrams) if count is None else count

    def changed():
        now = drops(server)
        return {key: now[key] - before[key] for key in NAMES if now[key] != before[key]}
    eventually(lambda: sum(changed().values()) >= wanted, f"{wanted} dropped, but {changed()} counted")
    expect(changed() == {name: wanted}, f"counted {changed()} and not {wanted} under {name}")
    return f"{wanted} datagrams counted under {name}, none answered"


def with_hand(function):
    """Gives the check a session of its own, and ends it."""
    def run(server):
        hand = Hand(server)
        try:
            hand.ask()
            return function(server, hand)
        finally:
            hand.close()
    return run


def damaged(datagram, place, bit=1):
    data = bytearray(datagram)
    data[place] ^= bit
    return bytes(data)


@check("S-201", "shorter than 40 bytes or longer than 1200")
@with_hand
def size(server, hand):
    long = hand.payload([hand.sample()])
    sizes = [hand.seal(b"", packet=900)[:39], b"", hand.seal(long + bytes(1161 - len(long)), packet=901), bytes(1500)]
    seen = expect_dropped(server, hand, sizes, "size")
    full = hand.payload([hand.sample()])
    hand.send(hand.seal(full + bytes(1160 - len(full))))
    expect(hand.reply()[1].get("sample_index") == hand.index, "1200 bytes were not taken")
    return seen + "; 39, 0, 1201 and 1500 bytes; 1200 were taken"


@check("S-202", "not `46 57`")
@with_hand
def magic(server, hand):
    return expect_dropped(server, hand, [hand.seal(hand.payload([hand.sample()]), magic=m) for m in (b"fw", b"WF", b"\0\0")], "magic")


@check("S-203", "not 1")
@with_hand
def version(server, hand):
    return expect_dropped(server, hand, [hand.seal(hand.payload([hand.sample()]), version=v) for v in (0, 2, 255)], "version")


@check("S-204", "unknown, or not for this side (a server takes 1, 3 and 4, a client 2 and 3, a follower 3 and 5)")
@with_hand
def kind(server, hand):
    return expect_dropped(server, hand, [hand.seal(hand.payload([hand.sample()]), kind=k) for k in (0, 2, 5, 6, 255)], "kind")


@check("S-205", "not zero")
@with_hand
def reserved(server, hand):
    return expect_dropped(server, hand, [hand.seal(hand.payload([hand.sample()]), reserved=r) for r in (1, 1 << 31)], "reserved")


@check("S-206", "no such session here.")
@with_hand
def session(server, hand):
    scene = hand.session & 0xFF  # other low bytes may name other scenes, which count for themselves
    wrong = [hand.seal(hand.payload([hand.sample()]), session=s) for s in (scene, hand.session ^ 0x100, 2**64 - 0x100 + scene)]
    return expect_dropped(server, hand, wrong, "session")


@check("S-207", "0, seen before, or 1024 and more behind the highest")
@with_hand
def packet_number(server, hand):
    first = hand.send(hand.tell())
    expect(hand.reply()[1].sample_index == hand.index, "no answer")
    hand.packet = 3000
    hand.ask()
    highest = hand.packet
    old = [first, hand.seal(hand.payload([hand.sample()]), packet=0), hand.seal(hand.payload([hand.sample()]), packet=highest - 1024),
           hand.seal(hand.payload([hand.sample()]), packet=highest)]
    seen = expect_dropped(server, hand, old, "packet_number")
    hand.send(hand.seal(hand.payload([hand.sample()]), packet=hand.packet - 1023))
    expect(hand.reply()[1].sample_index == hand.index, "the packet number 1023 behind the highest was not taken")
    return seen + "; 1023 behind the highest was taken"


@check("S-208", "no key for its generation, or the tag is wrong.")
@with_hand
def sealed(server, hand):
    good = hand.seal(hand.payload([hand.sample()]), packet=500)
    head = sealing.header(sealing.SAMPLES, hand.session, 501)
    payload = hand.payload([hand.sample()])
    wrong = [damaged(good, 0 + n) for n in (24, len(good) - 1, len(good) - 16)]
    wrong.append(hand.down.seal(head, payload))  # the keys of the other direction
    wrong.append(hand.up.seal(head, payload, nonce=bytes(4) + struct.pack(">Q", 501)))
    wrong.append(hand.up.seal(head, payload, nonce=struct.pack("<Q", 501) + bytes(4)))
    wrong.append(damaged(good, 16, 2))  # another packet number than it was sealed for
    wrong.append(damaged(good, 3, 2))  # the same datagram as a goodbye
    return expect_dropped(server, hand, wrong, "sealed")


@check("S-209", """A datagram that passes was sent by the other end: only now its number counts as seen, even if the datagram is dropped
       further on, and only now keys advance""")
@with_hand
def seen_numbers(server, hand):
    packet = hand.packet + 5
    good = hand.seal(hand.payload([hand.sample()]), packet=packet)
    hand.index += 1
    expect_dropped(server, hand, [damaged(good, 30)], "sealed")
    later = hand.seal(hand.payload([hand.sample()]), packet=packet)
    hand.send(later)
    expect(hand.reply()[1].sample_index == hand.index, "a forged datagram took the number of a true one")
    packet += 5
    expect_dropped(server, hand, [hand.seal(b"\xff" * 40, packet=packet)], "malformed")
    expect_dropped(server, hand, [hand.seal(hand.payload([hand.sample()]), packet=packet)], "packet_number")
    return "a forged datagram takes no number, a sealed one that is dropped takes its own"


@check("S-210", """A receiver has the keys of the generation of the highest number that it has opened, of the next (made beforehand, so that
       received data do not decide what is computed), and of the one before while its window reaches back there; any other number is
       `sealed`.""")
@with_hand
def generations(server, hand):
    skipped = hand.seal(hand.payload([hand.sample()]), packet=2 * sealing.GENERATION + 7)
    expect_dropped(server, hand, [skipped], "sealed")
    hand.packet = sealing.GENERATION + 99
    expect(hand.ask().sample_index == hand.index, "the next generation was not taken")
    before = hand.seal(hand.payload([hand.sample()]), packet=sealing.GENERATION - 10)
    hand.send(before)
    expect(hand.reply()[1].sample_index == hand.index, "the generation before was not taken inside the window")
    hand.packet = 2 * sealing.GENERATION - 1
    expect(hand.ask().sample_index == hand.index, "the first number of generation 2 was not taken")
    return "generations 0, 1, 0 and 2 were taken in this order, generation 2 after 0 was dropped"


@check("S-211", """payload shorter than 8 bytes, or the FlatBuffers verifier refuses it (at most 4 tables, depth 4), or a number lies off its
       alignment from the payload's beginning, or a goodbye with an unknown reason""")
@with_hand
def malformed(server, hand):
    good = hand.payload([hand.sample()])
    start = struct.unpack_from("<I", good)[0]
    shifted = struct.pack("<I", start + 4) + bytes(4) + good[4:]  # all numbers of 8 bytes lie at a multiple of 4 only
    wrong = [b"", good[:7], bytes(8), b"\xff" * 64, good[:-40], struct.pack("<I", 1 << 31) + good[4:], shifted]
    datagrams = [hand.seal(payload) for payload in wrong]
    datagrams.append(hand.seal(flat.write(DATAGRAM, "Goodbye", {"reason": 6}), kind=sealing.GOODBYE))
    datagrams.append(hand.seal(flat.write(DATAGRAM, "Samples", {"previous": 0}), packet=hand.next_packet()))  # a required field is absent
    return expect_dropped(server, hand, datagrams, "malformed")


@check("S-212", """no sample, more than 9, or rotations present and not as many; more than 3 patches, more than 2 `others`, a whole patch and
       `surfaces` zero, 19 hands or 27 bodies, offsets present and not as many as patches, or normals present and not 2 or 3; a change
       whose number is not 1 to 63, whose name is longer than 64 bytes, or whose projection or storage is none""")
@with_hand
def count(server, hand):
    ten = [hand.sample() for _ in range(10)][::-1]
    turn = {"orientation": (1, 0, 0, 0)}
    wrong = [hand.payload([]), hand.payload(ten), hand.payload(ten[:2], rotations=[turn]), hand.payload(ten[:1], rotations=[turn] * 2)]
    seen = expect_dropped(server, hand, [hand.seal(payload) for payload in wrong], "count")
    hand.send(hand.seal(hand.payload([hand.sample() for _ in range(9)][::-1])))
    expect(hand.reply()[1].sample_index == hand.index, "9 samples were not taken")
    return seen + "; 9 samples were taken"


@check("S-213", "a sample index 0 or not below the one before; `previous` not below the oldest;")
@with_hand
def order(server, hand):
    n = hand.index + 100

    def of(*indices, **fields):
        return hand.seal(hand.payload([hand.sample(index=index) for index in indices], **fields))
    wrong = [of(0), of(n, 0), of(n, n), of(n, n + 1), of(n, n - 1, n - 1), of(n, previous=n), of(n, n - 1, previous=n - 1), of(n, previous=n + 1)]
    return expect_dropped(server, hand, wrong, "order")


@check("S-214", """NaN or infinity in any number, a position beyond +-1000 m on an axis, a squared quaternion norm more than 1e-3 from 1;""")
@with_hand
def not_finite(server, hand):
    nan, far = math.nan, math.nextafter(1000.0, 2000.0)
    wrong = [hand.tell((nan, 0, 0)), hand.tell((0, math.inf, 0)), hand.tell((0, 0, far)), hand.tell((-far, 0, 0))]
    for field in ("held_elastic", "held_frictional"):
        wrong.append(hand.seal(hand.payload([hand.sample(**{field: (0, nan, 0)})])))
    for turn in ((1.001, 0, 0, 0), (0.999, 0, 0, 0), (0, 0, 0, 0), (nan, 0, 0, 0)):
        wrong.append(hand.seal(hand.payload([hand.sample()], rotations=[{"orientation": turn}])))
    wrong.append(hand.seal(hand.payload([hand.sample()], rotations=[{"orientation": (1, 0, 0, 0), "held_torque": (0, 0, -math.inf)}])))
    for field in ("balance", "round_trip", "hand_damping"):
        wrong.append(hand.seal(hand.payload([hand.sample()], report={field: nan})))
    older = hand.sample((nan, 0, 0))
    wrong.append(hand.seal(hand.payload([hand.sample(), older])))
    seen = expect_dropped(server, hand, wrong, "not_finite")
    for at in ((1000.0, 0, 0), (0, -1000.0, 0)):
        expect(hand.ask(at).sample_index == hand.index, f"a position at {at} was not taken")
    hand.send(hand.seal(hand.payload([hand.sample()], rotations=[{"orientation": (1.0004, 0, 0, 0)}])))
    expect(hand.reply()[1].sample_index == hand.index, "a quaternion within 1e-3 was not taken")
    return seen + "; +-1000 m and a squared norm of 1.0008 were taken"


@check("S-215", "the newest sample is not newer than the newest taken before;")
@with_hand
def stale(server, hand):
    hand.index += 5
    hand.ask()
    newest = hand.index
    wrong = [hand.seal(hand.payload([hand.sample(index=index)])) for index in (newest, newest - 1, newest - 3, 1)]
    return expect_dropped(server, hand, wrong, "stale")


@check("S-216", "The first check that fails drops the datagram, counts it under that name and changes nothing else, except the counts of "
       "forgeries (`sealed`) and of samples sent (`rate`).")
@with_hand
def first_that_fails(server, hand):
    hand.packet = 2000
    hand.ask()
    nan, good, other = math.nan, hand.payload([hand.sample()]), hand.session ^ 0x100

    def sealed(samples, **fields):
        return hand.seal(hand.payload(samples, **fields))
    many = [hand.sample(index=hand.index + 50 - n) for n in range(10)]
    bad_place = {"position": (nan, 0, 0)}
    # Each one fails the check that it stands under and the next one that a datagram can fail with it.
    both = [("size", hand.seal(b"", magic=b"xx", packet=700)[:39]), ("magic", hand.seal(good, magic=b"xx", version=9)),
            ("version", hand.seal(good, version=9, kind=9)), ("kind", hand.seal(good, kind=9, reserved=1)),
            ("reserved", hand.seal(good, reserved=1, session=other)), ("session", hand.seal(good, session=other, packet=0)),
            ("packet_number", damaged(hand.seal(good, packet=1), 60)), ("sealed", damaged(hand.seal(b"\xff" * 30), 50)),
            ("count", sealed([many[0], *many])), ("order", sealed([{**many[1], **bad_place}, many[0]])),
            ("not_finite", sealed([{**hand.sample(index=1), **bad_place}]))]
    for name, datagram in both:
        expect_dropped(server, hand, [datagram], name)
    return f"{len(both)} datagrams that fail two checks were counted under the first"


@check("S-217", "A goodbye under the number of one of the last 64 sessions that ended here is not dropped: it is counted apart, and has no "
       "other effect")
@with_hand
def late_goodbye(server, hand):
    other = Hand(server)
    try:
        other.ask()
        other.goodbye()
        before = counters(server)["late_goodbyes"]
        other.goodbye()
        eventually(lambda: counters(server)["late_goodbyes"] == before + 1, "a second goodbye is counted apart")
        return expect_dropped(server, hand, [other.tell()], "session") + "; a second goodbye was counted as late_goodbyes"
    finally:
        other.close(leave=False)


@check("S-218", "a state of a session whose role is not follower, and a sample of one whose role it is, is `kind`.")
@with_hand
def state_of_a_hand(server, hand):
    state = {"index": 1, "time": 1, "orientation": (1, 0, 0, 0), "commanded_turn": (1, 0, 0, 0)}
    payload = flat.write(DATAGRAM, "FollowerState", {"state": state})
    return expect_dropped(server, hand, [hand.seal(payload, kind=4)], "kind")

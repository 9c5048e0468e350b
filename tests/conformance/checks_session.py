"""Checks of a server: replies, and the life of a session (PROTOCOL.md, "Life of a session", "A server must")."""
import time

import patience
import sealing
from checks import check, eventually, expect
from checks_datagram import counters, expect_dropped, with_hand
from hand import Hand
from schema import DATAGRAM

REASONS = DATAGRAM.enums["GoodbyeReason"].values
GAP = 1 << 3


def goodbye_of(hand, seconds=None, sock=None):
    """The reason of the next goodbye; replies before it are passed over."""
    end = time.monotonic() + (patience.LONGEST if seconds is None else seconds)
    while time.monotonic() < end:
        answer = hand.reply(max(0.0, end - time.monotonic()), sock)
        if answer is not None and answer[0].kind == sealing.GOODBYE:
            return {number: name for name, number in REASONS.items()}[answer[1].reason]
    return None


@check("S-301", "answer every datagram that brings a new sample with exactly one reply, to the address it came from, at once, or count it as "
       "`withheld` if the force deadband allows it;")
@with_hand
def one_reply_each(server, hand):
    places = [hand.socket, hand.new_socket(), hand.new_socket()]
    try:
        for turn in range(30):
            place = places[turn % 3]
            expect(hand.ask(sock=place).sample_index == hand.index, "another sample was answered")
        expect(all(hand.datagram(0.05, place) is None for place in places), "more replies than datagrams")
    finally:
        for place in places[1:]:
            place.close()
    return "30 datagrams from three ports in turn, one reply each, to the port that it came from"


@check("S-302", "u64, counted from 1 by the sender for the session and this direction, never used again")
def packet_numbers(server):
    hand = Hand(server)
    try:
        for _ in range(20):
            hand.ask()
        numbers = [head.packet for head, _ in hand.heads]
        expect(numbers == list(range(1, 21)), f"packet numbers {numbers}")
    finally:
        hand.close()
    return "the first 20 replies have the packet numbers 1 to 20"


@check("S-303", "40 to 1200 bytes: a header, then one FlatBuffer without file identifier or size prefix, encrypted, then its tag.")
@with_hand
def headers(server, hand):
    for _ in range(5):
        hand.ask()
    for head, size in hand.heads:
        fields = (head.magic, head.version, head.kind, head.reserved, head.session)
        expect(fields == (b"FW", 1, sealing.REPLY, 0, hand.session), f"a header has {fields}")
        expect(40 <= size <= 1200, f"{size} bytes")
    return f"magic, version, kind, reserved and session of {len(hand.heads)} replies, {hand.heads[-1][1]} bytes"


@check("S-304", "a reply without a model, a view or a robot has at most 264, with normals 312, with a `body` and normals 1108 (a `remote` has no "
       "`body` beside it).")
@with_hand
def size_of_a_reply(server, hand):
    for step in range(40):
        hand.ask((0.0005 * step, 0.0, -0.0001 * step))
    sizes = {size for _, size in hand.heads}
    expect(max(sizes) <= 264, f"{sizes} bytes")
    return f"replies of {sorted(sizes)} bytes in contact"


@check("S-305", "the newest sample that the command was computed from, never 0")
@with_hand
def echo(server, hand):
    for count in (1, 3, 9):
        samples = [hand.sample() for _ in range(count)]
        hand.send(hand.seal(hand.payload(samples[::-1])))
        _, reply = hand.reply()
        expect(reply.sample_index == samples[-1]["index"], f"{count} samples, the newest {samples[-1]['index']}: {reply.sample_index}")
        expect(reply.client_time == samples[-1]["client_time"], "the client's time of another sample")
        expect(reply.server_send_time >= reply.server_receive_time > 0, f"times {reply.server_receive_time}, {reply.server_send_time}")
    return "the newest of 1, 3 and 9 samples is answered, with its time"


@check("S-306", "server's clock when it processed the datagram")
@with_hand
def clock(server, hand):
    times = [hand.ask().server_receive_time for _ in range(10)]
    expect(times == sorted(times) and times[-1] > times[0], f"times {times}")
    return "times rise"


@check("S-307", "resultant of the contact forces")
@with_hand
def force(server, hand):
    for depth in (0.0, 0.001, 0.004):
        reply = hand.ask((0.0, 0.0, -depth))
        expect(abs(reply.elastic.z - 600 * depth) < 1e-6, f"{depth} m in a plane of 600 N/m: {reply.elastic.z} N")
        expect(abs(reply.elastic.x) < 1e-9 and abs(reply.elastic.y) < 1e-9, f"{reply.elastic}")
    expect(reply.torque is None and reply.rates is None and reply.model is None and reply.view is None, "more than was asked for")
    return "0, 0.6 and 2.4 N at 0, 1 and 4 mm in a plane of 600 N/m, no torque, rates, model or view"


@check("S-308", "1 if there was no command")
@with_hand
def bounding_report(server, hand):
    reply = hand.ask((0.0, 0.0, 0.1))
    expect(reply.report.ratio == 1.0, f"ratio {reply.report.ratio}")
    expect(reply.report.flags == 0 and reply.report.reserved == 0, f"flags {reply.report.flags:#x}, reserved {reply.report.reserved}")
    return "ratio 1, no flag, reserved zero in free space"


@check("S-309", "The reply says `gap` if some of them travelled (`previous` of the datagram is above j).")
@with_hand
def gaps(server, hand):
    def flags(index, previous):
        hand.send(hand.seal(hand.payload([hand.sample(index=index)], previous=previous)))
        return hand.reply()[1].report.flags & GAP
    before = counters(server)
    start = hand.index
    expect(not flags(start + 1, start), "a gap without a lost sample")
    expect(not flags(start + 5, start + 1), "a gap, although the samples between did not travel")
    expect(flags(start + 9, start + 7), "no gap, although a sample was lost")
    hand.index = start + 9
    eventually(lambda: counters(server)["gaps"] == before["gaps"] + 1, f"gaps {before['gaps']}, then {counters(server)['gaps']}")
    return "gap after a lost sample that travelled, none after samples that were left out"


@check("S-310", "Samples are taken by rising index, each once.")
@with_hand
def once(server, hand):
    before = counters(server)["samples"]
    memory = []
    for _ in range(6):
        memory = [hand.sample()] + memory[:3]
        hand.send(hand.seal(hand.payload(memory)))
        expect(hand.reply()[1].report.flags & GAP == 0, "a gap")
    eventually(lambda: counters(server)["samples"] - before >= 6, "6 samples are counted")
    expect(counters(server)["samples"] - before == 6, f"{counters(server)['samples'] - before} samples were counted of 6")
    memory = [hand.sample() for _ in range(3)][::-1]
    hand.send(hand.seal(hand.payload(memory)))
    hand.reply()
    eventually(lambda: counters(server)["samples"] - before == 9, "three new samples were not taken")
    return "6 datagrams with up to 3 repeated samples count 6, 3 new ones in a datagram count 3"


@check("S-311", "The first sample of a session has no displacement.")
def first_sample(server):
    hand = Hand(server)
    try:
        hand.send(hand.seal(hand.payload([hand.sample((0.0, 0.0, -0.002), index=1000, held_elastic=(5.0, 5.0, 5.0))], previous=1)))
        _, reply = hand.reply()
        expect(reply.sample_index == 1000 and reply.report.delivered_elastic == 0.0, f"{reply.report}")
        expect(reply.report.flags & GAP == 0, "a gap before the first sample")
    finally:
        hand.close()
    return "a first sample with index 1000 has no gap and no energy"


@check("S-312", "energy to the hand so far, of the force that the client reports as held; an estimate, because the server does not know samples "
       "that did not travel.")
@with_hand
def energy(server, hand):
    def at(x, held):
        hand.send(hand.seal(hand.payload([hand.sample((x, 0.0, 0.1), held_elastic=(held, 0.0, 0.0), held_frictional=(0.0, 1.0, 0.0))])))
        return hand.reply()[1].report
    before = at(0.0, 2.0)
    after = at(0.01, 7.0)
    gained = after.delivered_elastic - before.delivered_elastic
    expect(abs(gained - 0.02) < 1e-9, f"2 N held over 10 mm: {gained} J")
    expect(abs(after.delivered_frictional) < 1e-9, f"1 N across the movement: {after.delivered_frictional} J")
    return "2 N held over 10 mm deliver 0.02 J, 1 N across it nothing"


@check("S-313", "by flooding (goodbye, flooding),")
def flooding(server):
    hand = Hand(server, parameters={"servo_period": 0.1, "hold_time": 0.5})
    try:
        begin, sent = time.monotonic(), 0
        for _ in range(25):
            hand.send(hand.tell())
            sent += 1
        answered = []
        while (answer := hand.datagram(0.3)) is not None:
            answered.append(hand.read(answer)[0].kind)
        most = 15 + 15 * (time.monotonic() - begin) + 1
        expect(15 <= len(answered) <= most and set(answered) == {sealing.REPLY}, f"{len(answered)} of 25 were answered: 15 to {most:.0f} may")
        while sent < 2000:
            hand.send(hand.tell())
            sent += 1
            if (answer := hand.datagram(0.001)) is not None and hand.read(answer)[0].kind == sealing.GOODBYE:
                break
        else:
            expect(False, "2000 samples of a session that may send 15 a second did not end it")
        _, table = hand.read(answer)
        expect(table.reason == REASONS["flooding"], f"goodbye with reason {table.reason}")
    finally:
        hand.close()
    return f"{len(answered)} of 25 samples at once were answered; goodbye, flooding, after {sent}"


@check("S-314", "A datagram counts as its new samples, at least one.")
def weight_of_a_datagram(server):
    hand = Hand(server, parameters={"servo_period": 0.1, "hold_time": 0.5})
    try:
        begin = time.monotonic()
        for _ in range(2):
            hand.send(hand.tell(*[(0.0, 0.0, 0.1)] * 9))
        hand.send(hand.tell())
        took, indices = time.monotonic() - begin, []
        while (answer := hand.reply(0.3)) is not None:
            indices.append(answer[1].get("sample_index"))
        # 9 + 9 samples overdraw the 15 by 3, which come back within 0.2 s.
        expect(indices == [9, 18] or (took > 0.19 and indices == [9, 18, 19]), f"answered {indices}, sent within {took:.3f} s")
    finally:
        hand.close()
    return f"of datagrams with 9, 9 and 1 new samples, 15 allowed at once, those with the newest samples {indices} were answered"


@check("S-315", "3. It ends by a goodbye from the client,")
@with_hand
def leaving(server, hand):
    other = Hand(server)
    try:
        other.ask()
        before = counters(server)["left"]
        other.goodbye()
        eventually(lambda: counters(server)["left"] == before + 1, "the goodbye was not counted")
        seen = expect_dropped(server, hand, [other.tell()], "session")
        expect(other.datagram(0.0) is None, "a goodbye was answered")
    finally:
        other.close(leave=False)
    return seen + " after the goodbye"


@check("S-316", "ends a session; no goodbye datagram follows")
@with_hand
def leave_request(server, hand):
    other = Hand(server)
    try:
        other.ask()
        expect(other.control.ask("LeaveRequest", session=other.session).session == other.session, "another session")
        seen = expect_dropped(server, hand, [other.tell()], "session")
        expect(other.datagram(0.1) is None, "a goodbye followed")
    finally:
        other.close(leave=False)
    return seen + " after Left, and no goodbye came"


@check("S-317", "Closing it does not end a session.")
def closed_control(server):
    hand = Hand(server)
    try:
        hand.ask()
        hand.control.close()
        for _ in range(5):
            expect(hand.ask().sample_index == hand.index, "no answer")
            time.sleep(0.02)
        hand.goodbye()
    finally:
        hand.socket.close()
    return "the session is answered after its control connection is closed"


@check("S-318", "by silence (no sample accepted for the timeout: the server says goodbye, evicted),")
def silence(server):
    hand, lively = Hand(server), Hand(server)
    try:
        timeout, begin = hand.joined.silence_timeout, time.monotonic()
        hand.ask()
        lively.ask()
        last = hand.index
        reason = None
        while reason is None and time.monotonic() < begin + 3 * timeout:
            # Nothing of this is a sign of life: a stale sample, a forged datagram, one that is no message.
            good = hand.tell()
            forged = good[:-1] + bytes([good[-1] ^ 1])
            for datagram in (hand.seal(hand.payload([hand.sample(index=last)])), forged, hand.seal(b"\xff" * 32)):
                hand.send(datagram)
            lively.ask()
            reason = goodbye_of(hand, 0.02)
        took = time.monotonic() - begin
        expect(reason == "evicted", f"goodbye {reason} after {took:.1f} s")
        expect(took >= timeout, f"after {took:.2f} s, the timeout is {timeout} s")
        expect(lively.ask().sample_index == lively.index, "a session that is answered was ended too")
    finally:
        hand.close()
        lively.close()
    return f"goodbye, evicted, after {took:.2f} s of {timeout} s, in spite of stale, forged and malformed datagrams"


@check("S-319", "a goodbye to where the datagram with the highest packet number and a new sample came from.")
def address_of_the_goodbye(server):
    hand = Hand(server)
    second, third = hand.new_socket(), hand.new_socket()
    try:
        hand.ask()
        hand.ask(sock=second)
        hand.send(hand.seal(hand.payload([hand.sample(index=1)])), third)  # a higher packet number without a new sample
        admin = server.control("admin")
        admin.ask("Evict", session=hand.session)
        admin.close()
        reason = goodbye_of(hand, sock=second)
        expect(reason == "evicted", f"goodbye {reason} at the newest address")
        expect(hand.datagram(0.05, third) is None and hand.datagram(0.0) is None, "a goodbye came elsewhere")
    finally:
        second.close()
        third.close()
        hand.close()
    return "Evict: the goodbye came to the second of three ports, that of the newest sample"


@check("S-320", "They belong to this session alone and are made anew for every join, so no key ever meets a packet number twice.")
def own_keys(server):
    first = Hand(server)
    second = Hand(server, control=first.control)
    third = Hand(server)
    try:
        secrets = {keys.secrets[0] for hand in (first, second, third) for keys in (hand.up, hand.down)}
        expect(len(secrets) == 6, f"{len(secrets)} secrets of three sessions")
        for hand in (first, second, third):
            hand.ask()
        head = sealing.header(sealing.SAMPLES, first.session, 50)
        expect_dropped(server, first, [second.up.seal(head, first.payload([first.sample()]))], "sealed")
    finally:
        first.goodbye()
        first.socket.close()
        second.close()
        third.close()
    return "six secrets of three joins; a datagram with the keys of another session is dropped"


@check("S-321", "The suite is 1 (AES-256-GCM) where both CPUs have AES, else 2 (ChaCha20-Poly1305).")
def suites(server):
    hand = Hand(server, aes_256_gcm=False)
    try:
        expect(hand.suite == 2, f"suite {hand.suite} for a client without AES")
        expect(hand.ask().sample_index == hand.index, "no answer with suite 2")
    finally:
        hand.close()
    return "ChaCha20-Poly1305 for a client without AES, and it is answered"

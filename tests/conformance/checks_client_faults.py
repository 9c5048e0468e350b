"""Checks of a client: what it does with datagrams that it must drop, with silence, and at the end (PROTOCOL.md, "Faults")."""
import junk
import sealing
from checks import check, eventually, expect
from checks_client import granted
from model_admin import Refusal
from schema import DATAGRAM
from stage import plain, stage

TICK = 0.005  # [s] of the client's servo
IN_A_ROW = 4  # answers of one kind


@check("C-301", "The first check that fails drops the datagram, counts it under that name and changes nothing else, except the counts of "
       "forgeries (`sealed`) and of samples sent (`rate`).")
def dropped(subject):
    names, sent, phase = list(junk.KINDS), [], ["junk"]

    def answer(session, table):
        session.packet = max(session.packet, 3000)
        if phase[0] == "control":
            return {"force": (1.0, 0.0, 0.0)}
        name = names[len(sent) // IN_A_ROW % len(names)]  # a late tick looks at several answers at once, and shows the last
        sent.append(name)
        return junk.around(name, session, table, lambda: session.reply((0.0, 0.5, 0.0), 0, 1))
    with stage(subject, answer=answer, duration=300) as scene:
        def felt():
            return {junk.kind_of(force[0]): index for index, _, force in scene.samples() if force[0] != 0.0}
        scene.until(lambda: len(sent) >= 2 * IN_A_ROW * len(names) or felt(), f"{len(names)} kinds of datagrams that it must drop were sent")
        expect(not felt(), f"the hand felt, first at the samples, {felt()}")
        phase[0] = "control"
        scene.until(lambda: scene.samples()[-1][2][0] == 1.0, "a good reply along x is felt")
        expect(len(scene.requests("JoinRequest")) == 1, "the session ended")
        good = sum(force[1] == 0.5 for _, _, force in scene.samples())
        expect(good > len(sent) / 2, f"{good} of {len(sent)} samples held the force of the good replies")
    return f"{len(names)} kinds, each sent {2 * IN_A_ROW} times: nothing of them was felt; the good replies between them were"


@check("C-302", "A datagram that passes was sent by the other end: only now its number counts as seen, even if the datagram is dropped further "
       "on, and only now keys advance")
def number_of_a_forgery(subject):
    def answer(session, table):
        number = session.packet + 1
        forged = bytearray(junk.sealed(session, junk.reply(session, table, 0.9), packet=number))
        forged[-5] ^= 8
        return [bytes(forged), session.reply((0.0, 0.5, 0.0), 0, 1)]
    with stage(subject, answer=answer, duration=300) as scene:
        scene.until(lambda: sum(force[1] == 0.5 for *_, force in scene.samples()) > 10, "replies behind forged ones are felt")
    return "a forged datagram does not take the number of the true one behind it"


@check("C-303", "The packet number determines the key, so keys change without a message: after 2^22 datagrams, 70 minutes at 1 kHz.")
def generations(subject):
    first = []

    def answer(session, table):
        if not first:
            first.append(table.samples[0].index)
            session.packet = sealing.GENERATION - 12
        generation = (session.packet + 1) >> 22
        return {"force": (0.0, 0.5 + generation, 0.0)}
    with stage(subject, answer=answer, duration=300) as scene:
        scene.until(lambda: scene.samples() and scene.samples()[-1][2][1] == 1.5, "a reply of the generation 1 is felt")
        expect(any(force[1] == 0.5 for *_, force in scene.samples()), "no reply of generation 0 was felt")
    return "replies with the packet numbers 2^22 - 11 to 2^22 + 1 are felt"


def fade(subject, hold):
    """The held force along y from the last answer on, until it is zero: (client's time, force), and the time of the last answered sample."""
    state = {"answers": 0, "felt": False, "last": 0.0}

    def answer(session, table):
        newest = table.samples[0]
        state["felt"] = state["felt"] or (state["answers"] >= 20 and newest.held_elastic.y == 2.0)
        if state["felt"]:
            return []
        state["answers"], state["last"] = state["answers"] + 1, newest.client_time / 1e9
        return {"force": (0.0, 2.0, 0.0)}
    with stage(subject, answer=answer, duration=300, hold=hold, silence=20.0) as scene:
        def faded():
            samples = scene.samples()
            return state["felt"] and samples[-1][2][1] == 0.0 and samples[-1][1] > state["last"] + hold and samples
        scene.until(lambda: state["felt"], "the command is felt")
        samples = scene.until(faded, "the force is zero")
    return [(when, force[1]) for _, when, force in samples if when >= state["last"]], state["last"]


TRIES = 5  # a machine that stalls for the time of a fade leaves nothing to see


@check("C-304", "*Fades*: a command counts in full until half of `hold_time` after its arrival, then falls linearly to zero at `hold_time`.")
def fades(subject):
    hold = 0.4
    for _ in range(TRIES):
        series, answered = fade(subject, hold)
        last = max((place for place, entry in enumerate(series) if entry[1] == 2.0), default=0)
        slope = [(when, force) for when, force in series[last:] if 0.0 < force < 2.0]
        falls = all(a[1] >= b[1] for a, b in zip(slope, slope[1:]))
        if len(slope) >= 3 and falls:
            break
    expect(len(slope) >= 3, f"the force fell in {len(slope)} steps")
    expect(falls, "it rose without an answer")
    zero = next(when for when, force in series[last:] if force == 0.0)
    expect(slope[0][0] - answered >= hold / 2 - TICK / 5, f"it falls {slope[0][0] - answered:.3f} s after the answered sample")
    # Each point of the slope gives the time of arrival: all must be the same, within a tick.
    arrivals = [when - hold / 2 - (1 - force / 2.0) * hold / 2 for when, force in slope]
    expect(max(arrivals) - min(arrivals) < TICK, f"not linear: arrivals from {min(arrivals) - answered:.4f} to {max(arrivals) - answered:.4f} s")
    expect(arrivals[0] >= answered - TICK, "it is zero before it can be")
    expect(zero >= arrivals[0] + hold - TICK, f"zero {zero - arrivals[0]:.3f} s after the arrival")
    return f"2 N in full until {hold / 2} s, then {len(slope)} samples on a line to zero at {hold} s"


def faded_and_back(subject, hold):
    """The held force along y by time, from the sample at which a command that has faded in part comes back."""
    state = {"phase": "first"}

    def answer(session, table):
        held = table.samples[0].held_elastic.y
        if state["phase"] == "first" and held == 2.0:
            state["phase"] = "silent"
        if state["phase"] == "silent" and held == 0.0:
            state["phase"] = "first"  # this machine slept through the fade
        if state["phase"] == "silent" and held < 1.2:
            state["phase"], state["from"] = "again", table.samples[0].index
        return [] if state["phase"] == "silent" else {"force": (0.0, 2.0, 0.0)}
    with stage(subject, answer=answer, duration=300, hold=hold, silence=20.0) as scene:
        scene.until(lambda: state["phase"] == "again", "the force fell to a half")
        scene.until(lambda: scene.samples()[-1][2][1] == 2.0 and scene.samples()[-1][0] > state["from"] + 5, "it is whole again")
        return [(when, force[1]) for index, when, force in scene.samples() if index >= state["from"]]


@check("C-305", "A command that has faded in part comes back as slowly: all of it in half the hold time.")
def comes_back(subject):
    hold = 0.4
    for _ in range(TRIES):
        samples = faded_and_back(subject, hold)
        low = min(range(len(samples)), key=lambda place: samples[place][1])
        rising = samples[low:]
        steps = [(b[1] - a[1], b[0] - a[0]) for a, b in zip(rising, rising[1:]) if b[1] < 2.0]
        if len(steps) >= 3:
            break
    expect(len(steps) >= 3, f"back in {len(steps)} steps from {samples[low][1]:.2f} N")
    # Samples may be missing and ticks late: each step is judged by its own time.
    fast = [(step, gap) for step, gap in steps if step > 2.0 / (hold / 2) * max(gap, TICK) * 1.3 + 1e-6]
    expect(not fast, f"too fast: {fast[:3]}")
    return f"from {samples[low][1]:.2f} N to 2 N in {len(steps)} steps, none faster than 2 N in {hold / 2} s"


@check("C-314", "It falls from no more than the device's largest force, so there is no step: the fall takes at most that force off in half the "
       "hold time.")
def largest_force(subject):
    with stage(subject, answer=plain((0.0, 1000.0, 0.0)), duration=300) as scene:
        scene.until(lambda: sum(force[1] > 0 for *_, force in scene.samples()) > 10, "the command is felt")
        most = scene.requests("JoinRequest")[0].device.max_force
        held = max(force[1] for *_, force in scene.samples())
    expect(held <= most * (1 + 1e-6), f"{held:.2f} N are held, the device has {most} N")
    return f"1000 N are commanded, {held:.2f} N held, the device has {most} N"


@check("C-315", "After a cut in which the force faded to zero, however short, wait for small force and ramp begin anew, and only a reply to a "
       "sample made since ends the wait; after a shorter one the next answer is felt, rising as slowly as it faded")
def waits_after_a_cut(subject):
    state = {"phase": "touch", "count": 0, "held": []}

    def answer(session, table):
        newest, held = table.samples[0], table.samples[0].held_elastic.y
        state["count"] += 1
        if state["phase"] == "touch" and held == 2.0:
            state["phase"] = "cut"
        if state["phase"] == "cut" and held == 0.0:
            state["phase"], state["from"] = "wait", newest.index
        if state["phase"] == "wait":
            state["held"].append(held)
        # A machine that stalls makes a cut of its own, so the small force comes again and again.
        small = state["phase"] != "wait" and state["count"] % 60 < 20
        return [] if state["phase"] == "cut" else {"force": (0.0, 0.0 if small else 2.0, 0.0)}
    with stage(subject, answer=answer, duration=300, hold=0.4, silence=20.0, wait=0.05, path="press") as scene:
        scene.until(lambda: len(state["held"]) > 30, "30 samples after the cut are answered by the same force")
        felt = [force for force in state["held"] if force > 0.5]  # some comes back as the hand moves (docs/devices.md)
        expect(not felt, f"the force came back without a wait: {felt[:3]}")
        state["phase"], begin = "after", scene.samples()[-1][0]
        scene.until(lambda: any(force[1] == 2.0 for index, _, force in scene.samples() if index > begin), "it is felt again after a small one")
    return "2 N are not felt after a cut, until the server has commanded nothing for a moment"


@check("C-306", "treat its session as over at a goodbye, and as lost if nothing was answered for the silence timeout;")
def silence(subject):
    with stage(subject, answer=lambda session, table: [], silence=1.0, duration=300, reconnect=300) as scene:
        scene.until(lambda: len(scene.requests("JoinRequest")) >= 2, "it joins again after silence")
        times = [when for _, when, _ in scene.samples(scene.datagrams()[0][0].number)]
        took = times[-1] - times[0]
        expect(took >= 0.7, f"it gave up after {took:.2f} s of 1 s")
        one, two = scene.requests("JoinRequest")[:2]
        expect(all(repr(one.parameters[name]) == repr(two.parameters[name]) for name in one.parameters), "it joins with other parameters")
    return f"joined again {took:.2f} s after the first sample, by the same parameters"


@check("C-307", "reply to a sample never sent")
def no_sign_of_life(subject):
    def answer(session, table):
        session.packet = max(session.packet, 3000)
        return [junk.KINDS[name](session, table, 0.0) for name in ("sample never sent", "tag", "NaN force", "packet number 0", "session")]
    with stage(subject, answer=answer, silence=0.5, duration=300, reconnect=300) as scene:
        scene.until(lambda: len(scene.requests("JoinRequest")) >= 2, "replies that it must drop are no sign of life")
    return "five kinds of dropped replies are no sign of life: joined again"


@check("C-308", "sends no more; lost at once, joins again or ends")
def goodbye(subject):
    for reason in ("shutting_down", "evicted", "failed"):
        with stage(subject, answer=plain((0.0, 0.5, 0.0)), duration=300, reconnect=300, silence=20.0) as scene:
            scene.enough(5)
            first = next(iter(scene.server.sessions.values()))
            with scene.server.lock:
                scene.server.udp.sendto(first.goodbye(reason), first.address)
            scene.until(lambda: len(scene.requests("JoinRequest")) >= 2 or scene.run.process.poll() is not None, "it takes the goodbye")
            scene.until(lambda: scene.datagrams()[-1][0] is not first, "it sends in the new session")
            scene.enough(len(scene.server.arrived) + 10)
            sessions = [session for session, *_ in scene.datagrams()]
            begin = next(place for place, session in enumerate(sessions) if session is not first)
            expect(first not in sessions[begin:], f"datagrams of the old session after {reason}, and after those of the new one")
            expect(not scene.datagrams(3, first.number), "it answered the goodbye")
    return "after shutting_down, evicted and failed it sends no more, answers nothing, and joins again"


@check("C-309", "say goodbye when it leaves.")
def leaves(subject):
    with stage(subject, answer=plain((0.0, 2.0, 0.0)), duration=0.4, hold=0.8) as scene:
        status, _ = scene.run.wait()
        eventually(lambda: scene.datagrams(3), "a goodbye came")
        eventually(lambda: scene.server.counts.get("late_goodbyes"), "the goodbye came a second time")
        last = [entry[2].kind for entry in scene.server.datagrams][-1]
        reasons = [table.reason for *_, table, _ in scene.datagrams(3)]
        held = scene.samples()[-1][2][1] if scene.samples() else 0.0
    expect(last == 3 and reasons == [DATAGRAM.enums["GoodbyeReason"].values["leaving"]], f"goodbyes {reasons}, the last kind {last}")
    expect(held < 1.5, f"it left with {held:.2f} N of 2 N")
    expect(status == 0, f"exit status {status}")
    return f"goodbye, leaving, more than once, after the force fell to {held:.3f} N of 2 N"


@check("C-310", "Five may heal by themselves, so that a client that lost its session asks again: full, shutting_down, too_many, failed and bad_ticket.")
def heals(subject):
    codes = ["full", "too_many", "failed", "bad_ticket", "shutting_down"]
    left = [None, *codes]

    def grant(joined):
        code = left.pop(0) if left else None
        if code:
            raise Refusal(code, "for now")
        return joined
    with stage(subject, grant=grant, answer=lambda session, table: [], silence=0.4, duration=300, reconnect=300) as scene:
        scene.until(lambda: len({one[0].number for one in scene.datagrams()}) >= 2, "it joins again behind five refusals")
        asked = len(scene.requests("JoinRequest"))
    return f"after {', '.join(codes)} it asked again; joined with request {asked}"


@check("C-311", "A session that is joined anew after a lost one has all its parameters.")
def other_parameters(subject):
    joins = []

    def grant(joined):
        joins.append(1)
        return joined if len(joins) == 1 else granted(redundancy=1)(joined)
    with stage(subject, grant=grant, answer=lambda session, table: [], silence=0.4, duration=300, reconnect=300) as scene:
        def ends():
            return scene.run.process.poll() is not None or len(joins) > 2
        scene.until(ends, "it ends")
        expect(len(joins) == 2, f"{len(joins)} joins")
        expect(len({session.number for session, *_ in scene.datagrams()}) == 1, "it sends in a session with other parameters")
        status, output = scene.run.wait()
    expect(status != 0, f"exit status {status}")
    expect("redundancy" in output, f"it does not name the field: {output.strip()[-200:]}")
    return f"it ends, exit status {status}, after a grant of another redundancy"


@check("C-312", "The client takes a change whole or refuses it whole, and judges by itself:")
def refuses_change(subject):
    def answer(session, table):
        told = [one.report.flags for *_, one, _ in reports if one.report]
        done = told and told[-1] >> 2 & 63 == 5
        return {"force": (0.0, 0.5, 0.0), "change": None if done else {"number": 5, "mode": "contact_frame"}}
    reports = []
    with stage(subject, answer=answer, duration=300) as scene:
        def answered():
            reports[:] = scene.datagrams()
            return next((one.report.flags for *_, one, _ in reports if one.report and one.report.flags >> 2 & 63 == 5), None)
        expect(scene.until(lambda: scene.requests("JoinRequest"), "a JoinRequest")[0].laws_taken == 0, "it takes other laws")
        flags = scene.until(answered, "a report has the number of the change")
        expect(flags & 2, f"it took a change that its owner did not allow: flags {flags:#x}")
        count = len(reports)
        scene.until(lambda: len(scene.datagrams()) > count + 10, "it goes on")
        scene.until(lambda: scene.samples()[-1][2][1] == 0.5, "the same force as before is felt")
    return "a change of its law is answered with its number and refused; the hand feels the same"


@check("C-313", "for `keep_alive` at most, and each part (elastic, frictional, torque) no farther than to the point at which its product with "
       "its value in the reply is zero, so that no push becomes a pull.")
def rates(subject):
    state = []

    def answer(session, table):
        if len(state) > 10:
            return []
        state.append(table.samples[0].client_time / 1e9)
        return {"force": (0.0, 1.0, 0.0), "rates": {"elastic": (0.0, -10.0, 0.0)}}
    with stage(subject, answer=answer, grant=granted(keep_alive=0.2), duration=300, hold=0.4, silence=20.0) as scene:
        scene.until(lambda: len(state) > 10 and scene.samples()[-1][1] > state[-1] + 0.5, "half a second after the last answer")
        samples = [(when - state[-1], force[1]) for _, when, force in scene.samples()]
    pulled = [entry for entry in samples if entry[1] < 0.0]
    expect(not pulled, f"a push became a pull: {pulled[:3]}")
    expect(any(0.0 < force < 0.99 for _, force in samples), "the rate did not act")
    held = [entry for entry in samples if entry[1] > 0.01 and 0.15 < entry[0]]
    expect(not held, f"1 N that falls by 10 N/s is held after 0.15 s: {held[:3]}")
    return "1 N with -10 N/s falls to zero within 0.1 s and stays there, never below"

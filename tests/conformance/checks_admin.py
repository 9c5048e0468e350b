"""Checks of a server: what admins may do, and whose session it is (PROTOCOL.md, the table of requests)."""
import math
import time

from checks import check, expect
from checks_control import refused, with_control
from checks_datagram import with_hand
from checks_session import goodbye_of
from control import CODES, PARAMETERS, Refused
from hand import Hand

CHANGES = 0xff00  # of report.flags


@check("S-401", "session, client (its token's), scene, role; by rising id, those above `after`, at most 200; `more`: there are others behind")
@with_control("admin")
def list_sessions(server, control):
    hands = [Hand(server) for _ in range(3)]
    try:
        listed = control.ask("ListSessions", after=0).sessions
        ids = [one.session for one in listed]
        expect(ids == sorted(ids) and {hand.session for hand in hands} <= set(ids), f"{ids}")
        expect(all(one.client == "operator-client" for one in listed if one.session in {hand.session for hand in hands}), "another client")
        behind = [one.session for one in control.ask("ListSessions", after=ids[0]).sessions]
        expect(behind == ids[1:], f"after {ids[0]}: {behind}")
    finally:
        for hand in hands:
            hand.close()
    return f"{len(ids)} sessions by rising id; those above the first"


@check("S-402", "the session's token, an admin of its scene")
@with_hand
def whose_session(server, hand):
    stranger = server.control("other")
    for name, fields in (("LeaveRequest", {}), ("SetParameters", {"parameters": PARAMETERS})):
        refused("unknown_session", stranger, name, session=hand.session, **fields)
    stranger.close()
    expect(hand.ask().sample_index == hand.index, "the session of another client was ended")
    admin = server.control("admin")
    other = Hand(server)
    expect(admin.ask("LeaveRequest", session=other.session).session == other.session, "an admin was refused")
    admin.close()
    other.close(leave=False)
    return "unknown_session for another client's token; an admin may"


@check("S-403", "ends a session, of a scene that the token opens, with the goodbye `evicted`")
@with_control("admin")
def evict(server, control):
    hand = Hand(server)
    try:
        hand.ask()
        expect(control.ask("Evict", session=hand.session).session == hand.session, "another session")
        reason = goodbye_of(hand)
        expect(reason == "evicted", f"goodbye {reason}")
        refused("unknown_session", control, "Evict", session=hand.session)
    finally:
        hand.close(leave=False)
    return "Evicted, and the goodbye evicted"


@check("S-404", "Any other is refused (`bad_parameters`, with the field): the client leaves and joins again")
@with_hand
def set_parameters(server, hand):
    fields = {**PARAMETERS, "velocity_cutoff": 30.0}
    answer = hand.control.ask("SetParameters", session=hand.session, parameters=fields)
    expect(answer.parameters.velocity_cutoff == 30.0, f"velocity_cutoff {answer.parameters.velocity_cutoff} in force")
    for field, value in (("hold_time", 0.2), ("redundancy", 1), ("servo_period", 0.002), ("force_deadband", 0.1), ("side", 0)):
        try:
            hand.control.ask("SetParameters", session=hand.session, parameters={**fields, field: value})
        except Refused as answer:
            expect(answer.code == "bad_parameters" and field in answer.reason, f"{field}: {answer}")
            continue
        expect(False, f"{field} was changed while the session runs")
    expect(hand.ask().sample_index == hand.index, "no answer after the changes")
    return "velocity_cutoff is changed; hold_time, redundancy, servo_period, force_deadband and side are refused by name"


@check("S-405", "`not_supported` where it takes none);")
@with_hand
def no_change_unasked(server, hand):
    refused("not_supported", hand.control, "SetParameters", session=hand.session, parameters={**PARAMETERS, "mode": "contact_frame"})
    admin = server.control("admin")
    refused("not_supported", admin, "SetLink", session=hand.session, delay=0.1)
    admin.close()
    expect(all(hand.ask().change is None for _ in range(3)), "the client was asked for a change")
    return "another law and another link are refused; no reply has a change"


@check("S-406", "The wish of an admin is in every reply to a hand as `change`, until a `report` has its number:", "changes")
def changes(server):
    hand = Hand(server, laws_taken=1, link_taken=True)
    admin = server.control("admin")
    try:
        hand.ask()
        admin.ask("SetLink", session=hand.session, delay=0.01, jitter=0.002, loss=0.25)
        wishes = [hand.ask().change for _ in range(3)]
        expect(all(wish is not None and 1 <= wish.number <= 63 and abs(wish.link.loss - 0.25) < 1e-6 for wish in wishes), f"{wishes}")
        number = wishes[0].number
        admin.ask("SetParameters", session=hand.session, parameters={**PARAMETERS, "mode": "contact_frame"})
        newer = hand.ask().change
        expect(newer.number == number % 63 + 1, f"number {newer.number} after {number}")
        expect(newer.mode == "contact_frame" and newer.link is not None, f"the newer change is {newer}")
        expect(hand.ask(report={"flags": number << 2}).change is not None, "the number of an older change acknowledged the newer")
        expect(hand.ask(report={"flags": newer.number << 2}).change is None, "still there behind its acknowledgement")
    finally:
        admin.close()
        hand.close()
    return f"in each reply with the numbers {number} and {newer.number}; the newer keeps the link; gone with the report of its number"


@check("S-407", "A value that a scene file could not have is refused (`bad_parameters`, with the field and the range) and changes nothing; back: "
       "what was changed, for people.", "materials")
@with_hand
def materials(server, hand):
    admin = server.control("admin")
    try:
        before = hand.ask((0.0, 0.0, -0.001))
        for field, value in (("stiffness", -1.0), ("stiffness", math.inf), ("static_friction", -0.1), ("damping", -1.0)):
            reason = refused("bad_parameters", admin, "SetMaterial", scene=server.scene, object="desk", **{field: value})
            expect(field in reason, f"the reason does not name {field}: {reason}")
        expect(hand.ask((0.0, 0.0, -0.001)).elastic.z == before.elastic.z, "a refused value changed the force")
        admin.ask("SetMaterial", scene=server.scene, object="desk", stiffness=300.0)
        after = hand.ask((0.0, 0.0, -0.001))
        expect(abs(after.elastic.z - 0.3) < 1e-6, f"{after.elastic.z} N at 1 mm of 300 N/m")
        count = ((after.report.flags & CHANGES) - (before.report.flags & CHANGES)) % 0x10000 >> 8
        expect(count == 1, f"report.flags count {count} changes")
    finally:
        admin.ask("SetMaterial", scene=server.scene, object="desk", stiffness=600.0)
        admin.close()
    return "four values refused by name; 300 N/m are felt with the next sample, and counted in report.flags"


@check("S-408", "[m/s^2] on what moves, from the second step on; refused (`bad_parameters`) where nothing moves.", "materials")
@with_control("admin")
def gravity(server, control):
    return refused("bad_parameters", control, "SetGravity", scene=server.scene, gravity=(0.0, 0.0, -1.0))


@check("S-409", "0, or 0.01 to 100, else `bad_parameters`; `not_supported` where the scene has no seat or the session leads nothing", "materials")
@with_hand
def lead_share(server, hand):
    admin = server.control("admin")
    for share in (-1.0, 0.009, 100.1, math.nan):
        refused("bad_parameters", admin, "SetLead", session=hand.session, share=share)
    refused("not_supported", admin, "SetLead", session=hand.session, share=0.5)
    admin.close()
    return "four shares are bad_parameters; 0.5 is not_supported without a seat"


@check("S-410", "the scene's file anew: all its sessions go on in it, from their next sample on as if they had touched nothing yet,", "materials")
@with_hand
def reload(server, hand):
    admin = server.control("admin")
    before = hand.ask().report.flags & CHANGES
    version = admin.ask("DescribeScene", scene=server.scene).version
    expect(admin.ask("ReloadScene", scene=server.scene).scene == server.scene, "another scene")
    after = hand.ask().report.flags & CHANGES
    expect((after - before) % 0x10000 == 0x100, f"report.flags {before:#x}, then {after:#x}")
    expect(admin.ask("DescribeScene", scene=server.scene).version == version + 1, "the version did not rise by one")
    refused("unknown_scene", admin, "ReloadScene", scene="no such scene")
    admin.close()
    return "the session is answered, report.flags and the scene's version count one more"


@check("S-411", "With a `from` behind the last object the answer has no materials: so an observer asks whether anything has changed.", "materials")
@with_control("observer")
def describe_scene(server, control):
    one = control.ask("DescribeScene", scene=server.scene)
    expect(len(one.materials) == one.objects == 1 and one.materials[0].stiffness == 600.0, f"{one}")
    expect(control.ask("DescribeScene", scene=server.scene, **{"from": 1}).materials == [], "materials behind the last object")
    return "the material of the only object, none behind it"


@check("S-412", "Questions of both kinds and `ListScenes` together are limited to 20 a second, 60 at once unless configured otherwise, for a "
       "client that is no admin (`too_many`)", "limits")
@with_control("observer")
def too_many_questions(server, control):
    begin, answered = time.monotonic(), 0
    while True:
        kind, value = control.ask_any(("ListScenes", "DescribeScene")[answered % 2], **({"scene": server.scene} if answered % 2 else {}))
        took = time.monotonic() - begin
        if kind == "Refused":
            break
        answered += 1
        expect(answered <= server.burst + 20 * took + 1, f"{answered} questions within {took:.2f} s were answered")
    expect(value.code == CODES["too_many"], f"{value}")
    admin = server.control("admin")
    for _ in range(60):
        admin.ask("ListScenes")
    admin.close()
    return f"too_many after {answered} questions, {server.burst} at once allowed; an admin asks 60 more"


@check("S-413", "by rising number, those above `after`, at most 64; `more`: there are others behind.", "materials")
def describe_sessions(server):
    hands = [Hand(server) for _ in range(2)]
    control = server.control("admin")
    try:
        for count in (65530, 4):  # modulo 2^16
            times = {"wakeups": [count] * 8, "round_trips": [7] * 8}
            hands[0].ask(report={"flags": 1, "balance": 0.25, "round_trip": 0.004}, times=times)
        listed = control.ask("DescribeSessions", scene=server.scene).sessions
        numbers = [one.number for one in listed]
        expect(numbers == sorted(numbers) and numbers[0] >= 1, f"numbers {numbers}")
        one, two = (next(entry for entry in listed if entry.session == hand.session) for hand in hands)
        expect((one.client, one.device, one.samples, one.balance) == ("checker", "probe", 2, 0.25), f"{one}")
        expect(abs(one.round_trip - 0.004) < 1e-6 and (one.times.wakeups, one.times.round_trips) == ([10] * 8, [0] * 8), f"{one}")
        expect(math.isnan(two.round_trip) and math.isnan(two.balance) and two.times is None, f"{two}")
        behind = [entry.number for entry in control.ask("DescribeSessions", scene=server.scene, after=one.number).sessions]
        expect(behind == [number for number in numbers if number > one.number], f"after {one.number}: {behind}")
    finally:
        control.close()
        for hand in hands:
            hand.close()
    return "what a report said is described, NaN where nothing was said; those above a number"

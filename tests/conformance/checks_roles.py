"""Checks of a server: observers, deadbands, hands side by side, what a client may fetch, tools, robots, tokens, limits."""
import time

import patience
from checks import check, eventually, expect
from checks_control import refused, with_control
from checks_datagram import with_hand
from checks_session import goodbye_of
from control import join_request
from hand import Hand

LATER = 2**32 - 1


@check("S-414", "An observer sends samples as an operator does (no hand feels or sees them); the answer is the view, and a command of zero.")
@with_hand
def observer(server, hand):
    watcher = Hand(server, role="observer")
    try:
        hand.ask((0.01, 0.02, -0.001))
        reply = watcher.ask((0.0, 0.0, -0.005), lead={"flags": 1})
        expect(all(reply[part][axis] == 0.0 for part in ("elastic", "frictional") for axis in "xyz"), f"{reply.elastic} {reply.frictional}")
        expect(reply.model is None and reply.remote is None, "a model or a robot beside the view")
        view = eventually(lambda: watcher.ask((0.0, 0.0, -0.005)).view, "a reply has a view")
        seen = [(round(one.position.x, 4), round(one.position.y, 4), round(one.position.z, 4)) for one in view.hands or []]
        expect(seen.count((0.01, 0.02, -0.001)) == 1 and (0.0, 0.0, -0.005) not in seen, f"hands at {seen}")
        expect((view.hands_from, view.hands_end) == (0, LATER), f"range {view.hands_from} to {view.hands_end}")
        expect(hand.ask((0.01, 0.02, 0.001)).view is None, "an operator's reply has a view")
    finally:
        watcher.close()
    return "a command of zero below the surface, a view with the hand at its place; an operator's reply has none"


@check("S-415", "datagrams that got no reply because of the force deadband, so far")
def withheld(server):
    quiet = Hand(server, parameters={"force_deadband": 0.2, "keep_alive": 0.5, "hold_time": 1.0})
    try:
        for _ in range(10):
            first = quiet.ask((0.0, 0.0, -0.002 * (1 + quiet.index)))
            begin = time.monotonic()
            quiet.send(quiet.tell((0.0, 0.0, -0.002 * quiet.index)))
            quiet.send(quiet.tell((0.0, 0.0, -0.02)))
            took, answer = time.monotonic() - begin, quiet.reply()[1]
            if took < 0.3:
                break  # else the machine was so slow that a reply was due
            quiet.reply(0.1)
        expect(answer.sample_index == quiet.index, "a datagram with the same force was answered")
        expect(answer.withheld == first.withheld + 1, f"withheld {answer.withheld} after {first.withheld}")
        expect(abs(answer.elastic.z - 12.0) < 1e-6, f"{answer.elastic}")
        begin = time.monotonic()
        while (answer := quiet.reply(0.0)) is None:
            quiet.send(quiet.tell((0.0, 0.0, -0.02)))
            expect(time.monotonic() - begin < patience.LONGEST, "no reply came after keep_alive")
            time.sleep(0.01)
    finally:
        quiet.close()
    return "no reply for the same force, one for another force and one after keep_alive; withheld counts"


@check("S-416", "never let one session's samples change another one's answers, except by their effect on moving objects, with no more than the "
       "device's largest force and the speed of a hand, and by the views of observers;")
@with_hand
def sessions_apart(server, hand):
    other = Hand(server)
    try:
        for step in range(10):
            mine, theirs = hand.ask((0.0, 0.0, -0.001)), other.ask((0.0, 0.0, -0.0001 * step))
            expect(abs(mine.elastic.z - 0.6) < 1e-6, f"{mine.elastic.z} N beside another hand")
            expect(abs(theirs.elastic.z - 0.06 * step) < 1e-6, f"{theirs.elastic.z} N at {0.1 * step:.1f} mm")
    finally:
        other.close()
    return "two hands at different depths are each answered for their own"


@check("S-417", "two sessions: a name is for people")
def two_with_one_name(server):
    first, second = Hand(server), Hand(server)
    expect(first.session != second.session and 0 not in (first.session, second.session), f"{first.session}, {second.session}")
    first.close()
    expect(second.ask().sample_index == 1, "the other session ended with the first")
    second.close()
    return "two joins with one name are two sessions, neither 0"


@check("S-418", "all surfaces within `reach` of `center` (the position of the answered sample), nearest first.", "models")
def local_model(server):
    hand = Hand(server, parameters={"local_model": True})
    try:
        model = hand.ask((0.01, 0.02, 0.003)).model
        expect((model.center.x, model.center.y, model.center.z) == (0.01, 0.02, 0.003), f"center {model.center}")
        patch = model.patches[0]
        expect(len(model.patches) == 1 and abs(patch.point.z + 0.003) < 1e-6 and abs(patch.normal.z - 1) < 1e-6, f"{patch}")
        expect(abs(patch.stiffness - 600) < 1e-3 and patch.flags & 1 == 0 and patch.curvature == 0, f"{patch}")
        touching = hand.ask((0.01, 0.02, -0.001)).model.patches[0]
        expect(touching.flags & 1 == 1 and (touching.feature, touching.object) == (patch.feature, patch.object), f"{touching}")
    finally:
        hand.close()
    return "the plane as one patch, its point 3 mm below, flag touching in contact, the same identity"


@check("S-419", "`bad_scene` if the scene has another version by now", "surfaces")
def surfaces(server):
    hand = Hand(server, scene="bunny", parameters={"local_model": True})
    control, stranger = hand.control, server.control("other")
    try:
        refused("unknown_session", stranger, "ListSurfaces", session=hand.session)
        listed = control.ask("ListSurfaces", session=hand.session)
        one = listed.surfaces[0]
        refused("bad_scene", control, "GetSurface", session=hand.session, version=listed.version + 1, object=one.object)
        refused("bad_scene", control, "TakeSurfaces", session=hand.session, version=listed.version + 1, objects=[])
        refused("bad_parameters", control, "TakeSurfaces", session=hand.session, version=listed.version, objects=[999])
        vertices, triangles, parts = 0, 0, 0
        while vertices < one.vertices or triangles < one.triangles:
            part = control.ask("GetSurface", session=hand.session, version=listed.version, object=one.object, vertices=vertices,
                               triangles=triangles)
            expect(len(part.vertices) <= 1200 and len(part.triangles) <= 1200, f"{len(part.vertices)} and {len(part.triangles)} in a part")
            expect(part.vertices or part.triangles, "a part brings nothing")
            expect(all(max(corner.a, corner.b, corner.c) < one.vertices for corner in part.triangles), "a corner that is no vertex")
            vertices, triangles, parts = vertices + len(part.vertices), triangles + len(part.triangles), parts + 1
        expect((vertices, triangles) == (one.vertices, one.triangles), f"{vertices}, {triangles} of {one.vertices}, {one.triangles}")
        start = hand.joined.start_position
        before = hand.ask((start.x, start.y, start.z)).model
        control.ask("TakeSurfaces", session=hand.session, version=listed.version, objects=[one.object])
        after = hand.ask((start.x, start.y, start.z)).model
        whole = [patch.object for patch in after.patches or [] if patch.flags & 32]
        expect(not any(patch.flags & 32 for patch in before.patches or []), "a whole patch before TakeSurfaces")
        expect(whole == [one.object] and after.surfaces == listed.version, f"whole patches of {whole}, version {after.surfaces}")
    finally:
        stranger.close()
        hand.close()
    return f"{vertices} vertices and {triangles} triangles in {parts} parts of 1200 at most; one whole patch behind TakeSurfaces"


@check("S-420", "12 unknown_tool (the reason lists the existing ones),", "tools")
@with_control("operator")
def tools(server, control):
    reason = refused("unknown_tool", control, "JoinRequest", **join_request("mallet", tool="no such tool"))
    expect("mallet" in reason and "bar" in reason, f"the reason is: {reason}")
    hand = Hand(server, scene="mallet", tool="bar")
    expect(hand.joined.tool == "bar" and hand.joined.port_offset in (1, server.offsets["mallet"]), f"{hand.joined}")
    hand.close()
    return reason


@check("S-422", "evicts its sessions, with a goodbye, within a second", "tokens")
def revoked(server):
    hand = Hand(server, token=server.token("doomed"))
    try:
        hand.ask()
        server.revoke("doomed")
        end, reason = time.monotonic() + 20, None
        while reason is None and time.monotonic() < end:
            hand.send(hand.tell())
            reason = goodbye_of(hand, 0.02)
        expect(reason == "evicted", f"goodbye {reason}")
        refused("unauthenticated", hand.control, "ListScenes")
        expect(hand.control.closes(), "the connection stays open")
        again = server.control()
        refused("unauthenticated", again, "Authenticate", token=server.token("doomed"))
        again.close()
    finally:
        hand.close(leave=False)
    return "goodbye, evicted; the next request is unauthenticated and the connection closed; the token is refused"


@check("S-423", "8 forbidden (the token's role or scene),", "tokens")
@with_control("narrow")
def other_scene(server, control):
    refused("forbidden", control, "JoinRequest", **join_request(server.scene))
    names = [one.name for one in control.ask("ListScenes").scenes]
    expect(names == ["mallet"], f"scenes {names}")
    Hand(server, scene="mallet", token=server.token("narrow")).close()
    return "a token of one scene joins there only, and lists no other"


@check("S-424", "Five may heal by themselves, so that a client that lost its session asks again: full, shutting_down, too_many, failed and bad_ticket.", "limits")
def full(server):
    hands = []
    try:
        for role, most, code in (("operator", 16, "too_many"), ("other", server.most_sessions - 16, "full")):
            control = server.control(role)
            for _ in range(most):
                hands.append(Hand(server, token=server.token(role)))
                for hand in hands:  # none falls silent
                    hand.send(hand.tell())
            refused(code, control, "JoinRequest", **join_request(server.scene))
            control.close()
    finally:
        for hand in hands:
            hand.close()
    return f"the 17th session of a client is too_many, the {server.most_sessions + 1}th of a scene is full"


@check("S-425", "The server closes a connection that has shown no valid token within 5 s, later one that sends no request for 60 s.", "slow")
def no_token(server):
    took = server.silent_connection_closed()
    expect(took is not None and took > 4.5, f"closed after {took} s")
    return f"closed after {took:.1f} s"


@check("S-999", "say goodbye to every client when it ends.")
def end(server):
    hands = [Hand(server), Hand(server), Hand(server, role="observer")]
    for hand in hands:
        hand.ask()
    server.end()
    reasons = [goodbye_of(hand) for hand in hands]
    for hand in hands:
        hand.socket.close()
    expect(reasons == ["shutting_down"] * 3, f"goodbyes {reasons}")
    return "two hands and an observer got the goodbye shutting_down"

"""Checks of a server: TLS, frames, tokens, joins and what it refuses (PROTOCOL.md, "Control (TLS)")."""
import struct

import flat
import tls13
from checks import check, expect
from control import CODES, VERSIONS, Control, Refused, frame, join_request, read_frame
from hand import Hand
from schema import CONTROL, DATAGRAM, Schema

MOST_NAME = 128


def refused(code, control, name, **fields):
    """The reason of the refusal; a Failure if the answer is another."""
    kind, value = control.ask_any(name, **fields)
    expect(kind == "Refused", f"{name} was answered by {kind}")
    names = {number: text for text, number in CODES.items()}
    expect(value.code == CODES[code], f"{name} was refused with {names.get(value.code)} ({value.reason}), not {code}")
    return value.reason


def with_control(role):
    """Gives the check a connection with the token of a role."""
    def wrap(function):
        def run(server):
            control = server.control(role)
            try:
                return function(server, control)
            finally:
                control.close()
        return run
    return wrap


@check("S-101", "TLS 1.3 only; no tickets, no resumption, no early data.")
def only_tls13(server):
    for version in (tls13.TLS11, tls13.TLS12):
        try:
            Control(server, version=version).close()
        except tls13.Closed:
            continue
        expect(False, f"{version.name} was accepted")
    control = server.control("operator")
    control.ask("ListScenes")
    expect(control.tls.version() == "TLSv1.3", f"version {control.tls.version()}")
    expect(not control.tls.has_ticket(), "a ticket came")
    expect(control.tls.fingerprint() == server.fingerprint, "another certificate than the fingerprint says")
    control.close()
    return "TLS 1.2 and 1.1 are closed, TLS 1.3 is taken, no ticket came with the first answers"


@check("S-102", "A frame of length 0 is answered with `Refused`, malformed, before a token is requested; a health check uses this to find out "
       "whether a server is running.")
def empty_frame(server):
    control = server.control()
    kind, value = control.raw(struct.pack("<I", 0))
    expect((kind, value.get("code")) == ("Refused", CODES["malformed"]), f"answered by {kind} {value}")
    expect(control.closes(), "the connection stays open")
    control.close()
    return "Refused, malformed, without a token; then closed"


@check("S-103", "A frame is a u32 length of its contents, then a FlatBuffer with root `ControlMessage`: 1 to 65536 bytes, to 512 until the "
       "token is accepted.")
def frame_lengths(server):
    for size, role in ((513, None), (65536, None), (65537, "operator"), (2**32 - 1, "operator")):
        control = server.control(role)
        kind, value = control.raw(struct.pack("<I", size))
        expect((kind, value.get("code")) == ("Refused", CODES["malformed"]), f"a length of {size} was answered by {kind} {value}")
        expect(control.closes(), f"the connection stays open after a length of {size}")
        control.close()
    control = server.control()
    message = frame(("Authenticate", {"token": server.token("operator"), **VERSIONS}))[4:]
    kind, value = control.raw(struct.pack("<I", 512) + message + bytes(512 - len(message)))
    expect(kind == "Authenticated", f"512 bytes before the token: {kind} {value}")
    message = frame(("ListScenes", {}))[4:]
    kind, value = control.raw(struct.pack("<I", 65536) + message + bytes(65536 - len(message)))
    expect(kind == "SceneList", f"65536 bytes: {kind} {value}")
    control.close()
    return "513 bytes before the token and 65537 after it are malformed and closed; 512 and 65536 are read"


@check("S-104", "7 unauthenticated (no token, or one that is wrong, expired, revoked or unknown: alike)")
def tokens(server):
    good = server.token("operator")
    answers = {}
    wrong = {"none": ("ListScenes", {}), "join": ("JoinRequest", {**join_request(server.scene), "device": {"name": "d"}}),
             "empty": ("Authenticate", {"token": ""}), "of no form": ("Authenticate", {"token": "hello"}),
             "unknown": ("Authenticate", {"token": "fw_0123456789ab_" + good.split("_")[2]}),
             "wrong": ("Authenticate", {"token": good[:-1] + ("A" if good[-1] != "A" else "B")})}
    for name, (request, fields) in wrong.items():
        control = server.control()
        answers[name] = refused("unauthenticated", control, request, **fields)
        expect(control.closes(), f"the connection stays open after a token that is {name}")
        control.close()
    alike = {answers[name] for name in ("of no form", "unknown", "wrong")}
    expect(len(alike) == 1, f"the reasons differ: {alike}")
    return f"{len(wrong)} connections refused and closed, wrong and unknown tokens alike"


@check("S-105", "After `malformed` (a length out of range, bytes that are no message, a message that is no request), and after any while no "
       "valid token was shown, the server closes the connection; after the others it stays open.")
def closed_or_open(server):
    garbage = b"\x10\x00\x00\x00" + b"\xff" * 16
    no_request = frame(("Left", {"session": 1}))
    unknown = bytearray(frame(("Left", {"session": 1})))
    unknown[unknown.index(4, 12)] = 200  # the type of the union
    for data in (garbage, no_request, bytes(unknown)):
        control = server.control("operator")
        kind, value = control.raw(data)
        expect((kind, value.get("code")) == ("Refused", CODES["malformed"]), f"{data[:24].hex()} was answered by {kind} {value}")
        expect(control.closes(), f"the connection stays open after {data[:24].hex()}")
        control.close()
    control = server.control("operator")
    refused("unknown_scene", control, "JoinRequest", **join_request("no such scene"))
    refused("bad_device", control, "JoinRequest", **join_request(server.scene, {"damping": -1.0}))
    refused("unknown_session", control, "LeaveRequest", session=12345)
    expect(control.ask("ListScenes") is not None, "no answer after a refusal")
    control.close()
    return "no message, an answer and an unknown kind are malformed and closed; other refusals leave the connection open"


@check("S-106", "One request at a time; each gets one answer, in the order in which they came.")
@with_control("operator")
def one_answer_each(server, control):
    requests = [("ListScenes", {}), ("LeaveRequest", {"session": 7}), ("ListScenes", {}), ("Evict", {"session": 7})]
    control.tls.send(b"".join(frame(request) for request in requests))
    kinds = [read_frame(control.tls)[0] for _ in requests]
    expect(kinds == ["SceneList", "Refused", "SceneList", "Refused"], f"answers {kinds}")
    control.patience(0.2)
    try:
        extra = read_frame(control.tls)
        expect(False, f"one more answer: {extra}")
    except tls13.Silent:
        return "four requests in one write got four answers in their order, and no more"


@check("S-107", "Client, scene, device and tool names and tokens have at most 128 bytes, the name of a bounding method 64; a message with a "
       "longer one is malformed.")
def long_names(server):
    long = "x" * (MOST_NAME + 1)
    base = join_request(server.scene)
    requests = {"client": {**base, "client": long}, "scene": {**base, "scene": long}, "tool": {**base, "tool": long},
                "device": {**base, "device": {**base["device"], "name": long}},
                "mode": {**base, "parameters": {**base["parameters"], "mode": "m" * 65}}}
    for name, request in requests.items():
        control = server.control("operator")
        refused("malformed", control, "JoinRequest", **request)
        expect(control.closes(), f"the connection stays open after a long {name}")
        control.close()
    control = server.control()
    refused("malformed", control, "Authenticate", token=long)
    control.close()
    hand = Hand(server, client="c" * MOST_NAME, device={"name": "d" * 100})
    hand.close()
    control = server.control("operator")
    refused("bad_parameters", control, "JoinRequest", **join_request(server.scene, parameters={"mode": "m" * 64}))
    refused("unknown_scene", control, "JoinRequest", **join_request("s" * MOST_NAME))
    control.close()
    return "129 bytes of five names and 65 of a method are malformed; 128 and 64 are read"


@check("S-108", "the first of a connection: a token; back: the client's name of the token, the scene that it opens (`*`: any), its role")
def authenticated(server):
    for role in ("observer", "pointer", "operator", "admin"):
        control = server.control(role)
        identity = control.identity
        expect((identity.client, identity.scene, identity.role) == (f"{role}-client", "*", server.role_number(role)), f"{role}: {identity}")
        control.close()
    return "four tokens are answered with client, scene and role"


@check("S-109", "A server that does not know the name refuses with `bad_parameters` and the names that it knows")
@with_control("operator")
def unknown_mode(server, control):
    reason = refused("bad_parameters", control, "JoinRequest", **join_request(server.scene, parameters={"mode": "no_such_law"}))
    expect("contact_frame" in reason and "none" in reason, f"the reason is: {reason}")
    return reason[:100]


LIMITS = {
    "servo_period": ((0.99e-5, 0.1001), (1e-5, 0.1)), "redundancy": ((9,), (8,)), "operator_damping": ((-1.0, 100.1), (100.0,)),
    "velocity_cutoff": ((-1.0, 1.001e5), (1e5,)), "hold_time": ((0.0009, 1.001), (0.001, 1.0)), "c1": ((-1.0, 1.001e9), (1e9,)),
    "coupling_stiffness": ((-1.0, 1.001e9), (1e9,)), "coupling_damping": ((-1.0, 1.001e6), (1e6,)), "tool_mass": ((0.9e-6, 1.001e3), (1e3,)),
    "packet_interval": ((0, 1001, 101), (100,)), "batch": ((0, 2), (1,)), "position_deadband": ((-0.1, 0.51), (0.5,)),
    "force_deadband": ((-0.1, 0.51), (0.5,)), "keep_alive": ((-0.1, 1.01), (1.0,)),
}


@check("S-110", "A value out of its range is refused (`bad_parameters`, with the field), and so is a combination that this table forbids.")
def ranges(server):
    control, tried = server.control("operator"), 0
    for field, (wrong, right) in LIMITS.items():
        for value in (*wrong, float("nan") if field in ("hold_time", "servo_period", "tool_mass") else wrong[0]):
            try:
                control.ask("JoinRequest", **join_request(server.scene, parameters={field: value}))
            except Refused as answer:
                expect(answer.code == "bad_parameters" and field in answer.reason, f"{field} = {value}: {answer}")
                tried += 1
                continue
            expect(False, f"{field} = {value} was granted")
        for value in right:
            more = {"servo_period": {"hold_time": 1.0}, "keep_alive": {"hold_time": 1.0}}.get(field, {})
            hand = Hand(server, parameters={field: value, **more}, control=control)
            granted = hand.joined.parameters[field]
            expect(granted == value, f"{field} = {value} was requested, {granted} granted")
            control.ask("LeaveRequest", session=hand.session)
            hand.socket.close()
    control.close()
    return f"{tried} values out of range were refused with bad_parameters; those at the limits were granted as requested"


@check("S-111", "virtual_coupling and passivity_control_parallel need side server; shaped, midpoint and credited need side client.")
@with_control("operator")
def sides(server, control):
    wrong = [("virtual_coupling", "client"), ("virtual_coupling", "both"), ("passivity_control_parallel", "client"), ("shaped", "server"),
             ("midpoint", "both"), ("credited", "server")]
    for mode, side in wrong:
        fields = {"mode": mode, "side": {"server": 0, "client": 1, "both": 2}[side]}
        refused("bad_parameters", control, "JoinRequest", **join_request(server.scene, parameters=fields))
    return f"{len(wrong)} laws with the other side were refused"


@check("S-112", "default false; not with side server")
@with_control("operator")
def model_and_side(server, control):
    refused("bad_parameters", control, "JoinRequest", **join_request(server.scene, parameters={"local_model": True, "side": 0}))
    return "refused with bad_parameters"


@check("S-113", "Another length, or numbers off their alignment, is a malformed message.")
def tensors(server):
    for field in ("damping_tensor", "rotational_damping_tensor"):
        for length in (1, 2, 4, 5, 7):
            control = server.control("operator")
            refused("malformed", control, "JoinRequest", **join_request(server.scene, {field: [5.0] * length}))
            control.close()
    for tensor in ([5.0, 6.0, 7.0], [5.0, 6.0, 7.0, 0.0, 0.0, 0.0]):
        Hand(server, device={"damping_tensor": tensor}).close()
    return "lengths 1, 2, 4, 5 and 7 are malformed; 3 and 6 are taken"


DEVICES = {
    "name": (("", "d" * 101), ("d", "d" * 100)), "translation_dof": ((0, 1, 4), (2, 3)), "rotation_sensed": ((1, 4), (0, 3)),
    "rotation_actuated": ((1, 3), (0,)), "damping": ((-1.0, 1000.1, float("nan")), (0.0, 1000.0)), "rotational_damping": ((-1.0, 100.1), (100.0,)),
    "apparent_mass": ((-1.0, 1000.1), (1000.0,)), "coulomb_friction": ((-1.0, 10000.1), (10000.0,)),
    "position_resolution": ((-1.0, 0.0101), (0.0, 0.01)), "max_force": ((0.0, -1.0, 10000.1), (3.0, 10000.0)),
    "continuous_force": ((-1.0, 8.1), (0.0, 8.0)), "max_torque": ((-1.0, 0.1, 1000.1), (0.0,)),
    "workspace": (((-0.1, 0.0, 0.0), (0.0, 0.0, 100.1)), ((0.0, 0.0, 0.0), (100.0, 0.0, 0.0))),
}


@check("S-117", """A device is refused (`bad_device`, with the field) if its name has not 1 to 100 bytes, if its translation has not 2 (x, y) or 3
       degrees of freedom or its rotation not 0 or 3 (`rotation_actuated` no more than `rotation_sensed`), or if a number is out of its
       range:""")
def devices(server):
    control = server.control("operator")
    for field, (wrong, right) in DEVICES.items():
        for value in wrong:
            reason = refused("bad_device", control, "JoinRequest", **join_request(server.scene, {field: value}))
            expect(field in reason, f"{field} = {value} is not named: {reason}")
        for value in right:
            joined = control.ask("JoinRequest", **join_request(server.scene, {field: value}))
            control.ask("LeaveRequest", session=joined.session)
    control.close()
    return f"{sum(len(wrong) for wrong, _ in DEVICES.values())} devices out of range are refused by the field's name; those at the limits join"


@check("S-118", "Fields of a table that a receiver does not know, and bytes behind the last object of the buffer, are ignored; so it is with the "
       "messages of the control port.")
def unknown_fields(server):
    newer = Schema(CONTROL.text.replace("  seat: string;", "  seat: string;\n  later: ulong;\n  other: string;", 1))
    request = {**join_request(server.scene), "later": 2**63, "other": "hello"}
    contents = flat.write(newer, "ControlMessage", {"body": ("JoinRequest", request)}) + bytes(40)
    control = server.control("operator")
    kind, joined = control.raw(struct.pack("<I", len(contents)) + contents)
    expect(kind == "JoinAccepted", f"a JoinRequest with more fields was answered by {kind} {joined}")
    control.ask("LeaveRequest", session=joined.session)
    hand = Hand(server, control=control)
    newer = Schema(DATAGRAM.text.replace("  times: HandTimes;", "  times: HandTimes;\n  later: ulong;\n  other: [Sample];", 1))
    sample = hand.sample()
    payload = flat.write(newer, "Samples", {"samples": [sample], "later": 7, "other": [sample]})
    hand.send(hand.seal(payload + bytes(24)))
    expect(hand.reply()[1].sample_index == 1, "samples with more fields were not answered")
    hand.close()
    return "a JoinRequest and a Samples with two fields more, and bytes behind them, are read as without"


@check("S-119", """A server that speaks no version of the client answers a good token with `Refused`, not_supported, and a reason that names the
       versions of both;""")
def versions(server):
    for old in ({}, {"newest_protocol": 1, "oldest_protocol": 1}, {"newest_protocol": 1000, "oldest_protocol": 1000}):
        control = server.control()
        reason = refused("not_supported", control, "Authenticate", token=server.token("operator"), **old)
        expect(f"version {old.get('newest_protocol', 1)}" in reason and "2" in reason, f"the reason is: {reason}")
        expect(control.closes(), "the connection stays open after a version that is not spoken")
        control.close()
    control = server.control()
    refused("malformed", control, "Authenticate", token=server.token("operator"), newest_protocol=2, oldest_protocol=3)
    control.close()
    control = server.control()
    refused("unauthenticated", control, "Authenticate", token="hello")  # a version is no token
    control.close()
    control = server.control()
    told = control.ask("Authenticate", token=server.token("operator"), newest_protocol=1000, oldest_protocol=1)
    expect(told.oldest_protocol <= 2 <= told.newest_protocol, f"the server says its versions as {told}")
    control.close()
    return reason


@check("S-120", "Each has 32 bytes of the system's random numbers, made anew for each join.")
def secrets(server):
    control, found = server.control("operator"), []
    for _ in range(3):
        hand = Hand(server, control=control)
        found += [bytes(hand.joined.secret_up or []), bytes(hand.joined.secret_down or [])]
        control.ask("LeaveRequest", session=hand.session)
        hand.socket.close()
    control.close()
    hand = Hand(server)
    found += [bytes(hand.joined.secret_up or []), bytes(hand.joined.secret_down or [])]
    hand.close()
    expect(all(len(one) == 32 for one in found), f"lengths {[len(one) for one in found]}")
    expect(len(set(found)) == len(found), "two secrets are equal")
    expect(all(len(set(one)) > 8 for one in found), "a secret is not random")  # 32 random bytes have so few values once in 1e15
    return "three joins by one connection and one by another have 8 different secrets of 32 bytes"


@check("S-114", "each may what those before it may.")
def roles(server):
    control = server.control("observer")
    for role in ("pointer", "operator", "admin"):
        refused("forbidden", control, "JoinRequest", **join_request(server.scene, {"max_force": 5.0}, role=server.role_number(role)))
    for name, fields in (("ListSessions", {}), ("Evict", {"session": 1}), ("GetCounters", {"scene": server.scene})):
        refused("forbidden", control, name, **fields)
    expect(control.ask("ListScenes").scenes[0].name == server.scene, "an observer lists no scenes")
    control.close()
    control = server.control("pointer")
    refused("forbidden", control, "JoinRequest", **join_request(server.scene))
    control.close()
    control = server.control("operator")
    for name in ("ListSessions", "GetCounters"):
        refused("forbidden", control, name)
    control.close()
    for role in ("observer", "pointer", "operator", "admin"):
        Hand(server, role="operator" if role == "operator" else role, token=server.token("admin"), device={"max_force": 5.0}).close()
    return "an observer, a pointer and an operator are refused what is above them; an admin joins in all four roles"


@check("S-115", "A pointer's is as an operator's, of a device of at most 10 N and 1000 samples a second, else it is refused (`forbidden`);")
@with_control("pointer")
def pointers(server, control):
    role = server.role_number("pointer")
    refused("forbidden", control, "JoinRequest", **join_request(server.scene, {"max_force": 10.01, "continuous_force": 1.0}, role=role))
    refused("forbidden", control, "JoinRequest",
            **join_request(server.scene, {"max_force": 10.0}, {"servo_period": 0.000999}, role=role))
    Hand(server, role="pointer", device={"max_force": 10.0}).close()
    return "10.01 N and 1001 samples a second are forbidden, 10 N and 1000 are taken"


@check("S-116", "name, port offset, objects, sessions of each scene that the token opens")
@with_control("observer")
def scenes(server, control):
    before = control.ask("ListScenes").scenes
    hand = Hand(server)
    after = control.ask("ListScenes").scenes
    hand.close()
    expect(before[0].name == server.scene and before[0].port_offset == hand.joined.port_offset == 1, f"{before}")
    expect(after[0].sessions == before[0].sessions + 1, f"{before[0].sessions} sessions, then {after[0].sessions}")
    return f"{server.scene} at port offset 1, {after[0].objects} objects; a session more after a join"

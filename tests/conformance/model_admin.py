"""What admins and observers may ask of the model server: the scene, its sessions, and changes of both. Limits of a client, too."""
import math
import time

from control import ROLES

MATERIAL = {"stiffness": (1e-300, 1e9), "damping": (0, 1e6), "static_friction": (0, 100), "dynamic_friction": (0, 100), "viscous_friction": (0, 1e6)}
QUESTIONS = ("ListScenes", "DescribeScene", "DescribeSessions")
RATE, BURST = 20, 60  # of questions [1/s], at once
OF_A_CLIENT, OF_THE_SCENE = 16, 20  # sessions


class Refusal(Exception):
    """The answer is Refused."""

    def __init__(self, code, reason="no"):
        self.code, self.reason = code, reason
        super().__init__(reason)


def count_question(connection):
    """Takes a question of a client's rate."""
    server, now = connection.server, time.monotonic()
    left, when = server.questions.get(connection.client, (BURST, now))
    left = min(BURST, left + RATE * (now - when))
    if left < 1 and connection.role != "admin" and "questions_unlimited" not in server.wrong:
        raise Refusal("too_many", "questions")
    server.questions[connection.client] = max(0, left - 1), now


def check_places(connection):
    """Refuses a join where the client or the scene has no place."""
    server = connection.server
    if "never_full" in server.wrong:
        return
    if sum(one.client == connection.client for one in server.sessions.values()) >= OF_A_CLIENT:
        raise Refusal("too_many", "sessions of this client")
    if len(server.sessions) >= OF_THE_SCENE:
        raise Refusal("full", "sessions of this scene")


def check_scene(server, value):
    if value.scene != server.scene:
        raise Refusal("unknown_scene", "there is no such scene")


def set_material(connection, value):
    server = connection.server
    check_scene(server, value)
    for field, (low, high) in MATERIAL.items():
        number = value[field]
        if not math.isnan(number) and not low <= number <= high and "any_material" not in server.wrong:
            raise Refusal("bad_parameters", f"{field}: must be from {low} to {high}")
    if not math.isnan(value.stiffness):
        server.stiffness = value.stiffness
        tell_change(server)
    server.changes += 1
    return "SceneChanged", {"scene": server.scene, "what": "the material"}


def tell_change(server):
    """Counts a change of the scene for all its sessions."""
    for session in server.sessions.values():
        session.changes += "changes_untold" not in server.wrong


def set_gravity(connection, value):
    if "gravity_taken" in connection.server.wrong:
        return "SceneChanged", {"scene": value.scene, "what": "gravity"}
    raise Refusal("bad_parameters", "gravity: nothing moves here")


def set_lead(connection, value):
    connection.session(value.session)
    if not (value.share == 0 or 0.01 <= value.share <= 100) and "any_share" not in connection.server.wrong:
        raise Refusal("bad_parameters", "share")
    raise Refusal("not_supported", "the scene has no seat")


def set_link(connection, value):
    server, session = connection.server, connection.session(value.session)
    if not session.request.link_taken and "asks_unasked" not in server.wrong:
        raise Refusal("not_supported", "the client takes no other link")
    session.ask_change({"link": (value.delay, value.jitter, value.loss)})
    return "SceneChanged", {"scene": server.scene, "what": "the link"}


def reload(connection, value):
    server = connection.server
    check_scene(server, value)
    server.scene_version, server.stiffness = server.scene_version + 1, 600.0
    tell_change(server)
    if "reload_ends" in server.wrong:
        for session in list(server.sessions.values()):
            server.end_session(session, "evicted", "evicted")
    return "SceneReloaded", {"scene": server.scene}


def describe_scene(connection, value):
    server = connection.server
    check_scene(server, value)
    material = (server.stiffness, 0.0, 0.0, 0.0, 0.0)
    listed = [material] if value["from"] == 0 or "from_ignored" in server.wrong else []
    return "SceneDescription", {"version": server.scene_version, "changes": server.changes, "objects": 1, "materials": listed}


def describe_sessions(connection, value):
    server = connection.server
    check_scene(server, value)
    listed = []
    for one in server.sessions.values():
        if one.place <= value.after and "after_ignored" not in server.wrong:
            continue
        entry = {"number": one.place, "session": one.number, "client": one.request.client, "device": one.request.device.name,
                 "role": ROLES[one.role], "parameters": one.parameters, "samples": one.taken, "times": one.times}
        if one.report is not None:
            entry |= {"balance": one.report.balance if one.report.flags & 1 else math.nan, "round_trip": one.report.round_trip}
        listed.append(entry)
    return "SessionDescriptions", {"sessions": listed}


ANSWERS = {"SetMaterial": set_material, "SetGravity": set_gravity, "SetLead": set_lead, "SetLink": set_link, "ReloadScene": reload,
           "DescribeScene": describe_scene, "DescribeSessions": describe_sessions}
ADMINS = ("SetMaterial", "SetGravity", "SetLead", "SetLink", "ReloadScene")

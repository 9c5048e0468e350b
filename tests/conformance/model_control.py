"""The control port of the model server: who a connection is, and the answers to its requests."""
import secrets
import struct
import time

import flat
import model_admin
import sealing
from control import CODES, ROLES, VERSIONS, frame
from model_admin import Refusal
from model_ranges import wrong_device, wrong_parameter
from model_session import Session
from schema import CONTROL

REQUESTS = ("JoinRequest", "LeaveRequest", "ListScenes", "SetParameters", "Evict", "ListSessions", "GetCounters", "Authenticate",
            *model_admin.ANSWERS)
ADMINS = ("Evict", "ListSessions", "GetCounters", *model_admin.ADMINS)
VERSION = VERSIONS["newest_protocol"]
ABOVE = {"observer": 0, "pointer": 1, "operator": 2, "admin": 3}
NAMES = {number: name for name, number in ROLES.items()}


class Connection:
    """One control connection: who it is, and its answers."""

    def __init__(self, server, tls):
        self.server, self.tls, self.role, self.client, self.joined = server, tls, None, None, []

    def serve(self):
        """Answers one request. False: the connection has to be closed."""
        limit = 65536 if self.role or "long_strangers" in self.server.wrong else 512
        size = struct.unpack("<I", self.tls.receive(4))[0]
        try:
            if size == 0 and "empty_needs_token" in self.server.wrong and self.role is None:
                raise Refusal("unauthenticated")
            if not 1 <= size <= limit:
                raise Refusal("malformed", "the length of the frame")
            try:
                contents = self.tls.receive(size)
                name, value = flat.read(CONTROL, "ControlMessage", contents)["body"]
                if "no_more_bytes" in self.server.wrong and not any(contents[-32:]):
                    raise flat.Malformed("more bytes than fields")
            except flat.Malformed as error:
                raise Refusal("malformed", str(error)) from error
            with self.server.lock:
                self.server.requests.append((time.monotonic(), name, value, size))
                answer = self.respond(name, value)
        except Refusal as refusal:
            self.tls.send(frame(("Refused", {"code": CODES[refusal.code], "reason": refusal.reason})))
            return "stays_open" in self.server.wrong or (self.role is not None and refusal.code != "malformed")
        self.tls.send(frame(answer) * (2 if "answers_twice" in self.server.wrong and answer[0] == "SceneList" else 1))
        return True

    def respond(self, name, value):
        if name not in REQUESTS:
            raise Refusal("malformed", "no request")
        limit = 1000 if "long_names" in self.server.wrong else 128
        texts = [text for text in value.values() if isinstance(text, str)] + [value.device.name if name == "JoinRequest" else ""]
        if any(len(text.encode()) > limit for text in texts):
            raise Refusal("malformed", "a name is too long")
        if name == "Authenticate":
            return self.authenticate(value)
        if self.role is None:
            raise Refusal("unauthenticated", "no token")
        if name in ADMINS and self.role != "admin" and "roles_ignored" not in self.server.wrong:
            raise Refusal("forbidden", "the role")
        if name in model_admin.QUESTIONS:
            model_admin.count_question(self)
        if name in model_admin.ANSWERS:
            return model_admin.ANSWERS[name](self, value)
        return getattr(self, "on_" + name)(value)

    def authenticate(self, value):
        if value.oldest_protocol > value.newest_protocol:
            raise Refusal("malformed", "versions")
        for role, token in self.server.tokens.items():
            if value.token == token:
                if not value.oldest_protocol <= VERSION <= value.newest_protocol and "any_client_version" not in self.server.wrong:
                    raise Refusal("not_supported", f"this client speaks version {value.newest_protocol} of the protocol, this server {VERSION}")
                self.role, self.client = {"other": "operator"}.get(role, role), f"{role}-client"
                told = "operator" if "role_hidden" in self.server.wrong else self.role
                versions = self.server.versions if "version_hidden" not in self.server.wrong else {}
                return "Authenticated", {"client": self.client, "scene": "*", "role": ROLES[told], **versions}
        known = any(token[:15] == value.token[:15] for token in self.server.tokens.values())
        raise Refusal("unauthenticated", "wrong secret" if known and "token_told" in self.server.wrong else "no valid token")

    def on_ListScenes(self, _value):
        server = self.server
        return "SceneList", {"scenes": [{"name": server.scene, "port_offset": 1, "objects": 1, "sessions": 0 if "sessions_hidden" in server.wrong else len(server.sessions)}]}

    def on_JoinRequest(self, value):
        server, role = self.server, NAMES[value.role]
        if "roles_ignored" not in server.wrong:
            if role == "follower" or ABOVE[role] > ABOVE[self.role]:
                raise Refusal("forbidden", "the role")
            small = value.device.max_force <= 10 and value.parameters.servo_period >= 0.001
            if role == "pointer" and not small and "large_pointers" not in server.wrong:
                raise Refusal("forbidden", "a pointer is small")
        if value.scene != server.scene:
            raise Refusal("unknown_scene", "there is no such scene")
        for field, rows in (("damping_tensor", value.device.damping_tensor), ("rotational", value.device.rotational_damping_tensor)):
            if rows is not None and len(rows) not in (3, 6) and "any_tensor" not in server.wrong:
                raise Refusal("malformed", field)
        field = wrong_device(value.device)
        if field and not ("any_device" in server.wrong and field == "max_force"):
            raise Refusal("bad_device", field)
        if len((value.parameters.mode or "").encode()) > 64:
            raise Refusal("malformed", "mode")
        wrong = wrong_parameter(value.parameters, server.wrong)
        if wrong and not ("ranges_ignored" in server.wrong and wrong == "hold_time"):
            raise Refusal("bad_parameters", wrong)
        model_admin.check_places(self)
        number = secrets.randbits(64) | 1
        if "one_session" in server.wrong and server.sessions:
            number = next(iter(server.sessions))
        suite = server.suite or (1 if value.aes_256_gcm or "always_aes" in server.wrong else 2)
        parameters = dict(value.parameters)
        if "hold_lengthened" in server.wrong:
            parameters["hold_time"] = min(1.0, 2 * parameters["hold_time"])
        answer = server.grant({"session": number, "port_offset": 1, "parameters": parameters, "silence_timeout": server.silence_timeout,
                               "start_normal": (0.0, 0.0, 1.0), "start_position": (0.0, 0.0, 0.0), "stiffness": 600.0, "suite": suite, **self.secrets()})
        if answer["session"]:
            keys = [sealing.Keys(suite, bytes(answer[name] or b"")) for name in ("secret_up", "secret_down")]
            if "wrong_secret" in server.wrong:
                keys[1] = sealing.Keys(suite, secrets.token_bytes(sealing.SECRET))
            server.sessions[number] = Session(number, self.client, role, answer["parameters"], keys, server.silence_timeout, server.wrong)
            server.sessions[number].request, server.hands = value, server.hands + 1
            server.sessions[number].place = server.hands
            self.joined.append(number)
            server.count("sessions_served")
        return "JoinAccepted", answer

    def secrets(self):
        """The secrets of a new session."""
        server = self.server
        up, down = secrets.token_bytes(sealing.SECRET), secrets.token_bytes(sealing.SECRET)
        if "secrets_reused" in server.wrong:
            up, down = server.first_secrets = getattr(server, "first_secrets", (up, down))
        if "secrets_equal" in server.wrong:
            down = up
        if "secret_short" in server.wrong:
            up = up[1:]
        return {"secret_up": up, "secret_down": down}

    def session(self, number):
        """A session that this connection's token may speak for."""
        one = self.server.sessions.get(number)
        own = one and (one.client == self.client or self.role == "admin")
        if not own and not (one and "strangers_rule" in self.server.wrong):
            raise Refusal("unknown_session", "there is no such session")
        return one

    def on_LeaveRequest(self, value):
        self.server.end_session(self.session(value.session), "evicted", "left", "leave_with_goodbye" in self.server.wrong)
        return "Left", {"session": value.session}

    def on_Evict(self, value):
        self.server.end_session(self.session(value.session), "evicted", "evicted")
        return "Evicted", {"session": value.session}

    def on_SetParameters(self, value):
        session = self.session(value.session)
        for name, new in value.parameters.items():
            old = session.parameters[name]
            if new == old or (new != new and old != old) or name == "velocity_cutoff" or "sets_all" in self.server.wrong:
                continue
            if name == "mode" and session.request.laws_taken:
                session.ask_change({"mode": new})
            else:
                raise Refusal("not_supported" if name in ("mode", "projection", "storage") else "bad_parameters", name)
        session.parameters = {**value.parameters, "mode": session.parameters["mode"]}
        return "ParametersSet", {"session": value.session, "parameters": session.parameters}

    def on_ListSessions(self, value):
        listed = [{"session": one.number, "client": one.client, "scene": "plane", "role": ROLES[one.role]}
                  for one in sorted(self.server.sessions.values(), key=lambda one: one.number)
                  if one.number > value.after or "after_ignored" in self.server.wrong]
        return "SessionList", {"sessions": listed}

    def on_GetCounters(self, _value):
        names = ["left", "late_goodbyes", "samples", "gaps", "withheld"] + [
            "dropped." + name for name in ("size magic version kind reserved session packet_number sealed rate malformed count order "
                                           "not_finite stale").split()]
        return "Counters", {"counters": [{"name": name, "value": self.server.counts.get(name, 0)} for name in names]}

"""A server in Python, made from PROTOCOL.md: sessions of one scene, the control port and the scene's port.

It is the server that the client's checks talk to, and, with deviations (`wrong`), the mutants that the server's checks must find.
`grant`, `answer` and `heard` let a check change what it grants, change what it answers, and see what came.
"""
import secrets
import select
import socket
import struct
import threading
import time

import flat
import openssl
import sealing
from control import CODES, ROLES, Control, frame
from model_ranges import wrong_device, wrong_parameter
from model_session import Dropped, Session
from schema import CONTROL, DATAGRAM

REQUESTS = ("JoinRequest", "LeaveRequest", "ListScenes", "SetParameters", "Evict", "ListSessions", "GetCounters", "Authenticate", "SetLink")
ADMINS = ("Evict", "ListSessions", "GetCounters", "SetLink")
ABOVE = {"observer": 0, "pointer": 1, "operator": 2, "admin": 3}
NAMES = {number: name for name, number in ROLES.items()}


class Refusal(Exception):
    def __init__(self, code, reason="no"):
        self.code, self.reason = code, reason
        super().__init__(reason)


class ModelServer:
    host = "127.0.0.1"
    has = ()

    def __init__(self, wrong=(), silence=0.6, suite=None, roles=("observer", "pointer", "operator", "admin", "other"), version=openssl.TLS13):
        self.wrong, self.silence_timeout, self.scene, self.suite, self.version = set(wrong), silence, "plane", suite, version
        self.identity = openssl.Identity()
        self.fingerprint = self.identity.fingerprint
        self.tokens = {role: f"fw_{secrets.token_hex(6)}_{secrets.token_hex(32)}" for role in roles}
        self.sessions, self.ended, self.counts = {}, [], {}
        self.requests, self.arrived, self.datagrams, self.connections = [], [], [], 0
        self.grant = lambda joined: joined
        self.answer = None  # (session, table) -> more fields of the reply, or a list of datagrams, or None: the usual one
        self.lock, self.running, self.threads = threading.RLock(), True, []
        self.listener, self.udp = self._ports()
        self.port = self.listener.getsockname()[1]
        self._start(self._accept)
        self._start(self._serve_datagrams)

    def _ports(self):
        while True:
            listener = socket.create_server((self.host, 0))
            udp = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
            try:
                udp.bind((self.host, listener.getsockname()[1] + 1))
                return listener, udp
            except OSError:
                listener.close()
                udp.close()

    def _start(self, function, *arguments):
        thread = threading.Thread(target=function, args=arguments, daemon=True)
        self.threads.append(thread)
        thread.start()

    # The server's checks need these of a server.
    def token(self, role):
        return self.tokens[role]

    def control(self, role=None):
        return Control(self, self.tokens[role] if role else None)

    @staticmethod
    def role_number(role):
        return ROLES[role]

    def end(self):
        """Says goodbye to every client and answers no more."""
        with self.lock:
            if "ends_silently" not in self.wrong:
                for session in list(self.sessions.values()):
                    self.say_goodbye(session, "shutting_down")
            self.sessions.clear()

    def close(self):
        self.end()
        self.running = False
        self.listener.close()
        self.udp.close()

    # Datagrams.
    def count(self, name, number=1):
        self.counts[name] = self.counts.get(name, 0) + number

    def say_goodbye(self, session, reason):
        if session.address:
            self.udp.sendto(session.goodbye(reason), session.address)

    def end_session(self, session, reason, name, goodbye=True):
        self.sessions.pop(session.number, None)
        self.ended = [*self.ended[-63:], session.number]
        self.count(name)
        if goodbye:
            self.say_goodbye(session, reason)

    def _serve_datagrams(self):
        while self.running:
            try:
                ready = select.select([self.udp], [], [], 0.02)[0]
                with self.lock:
                    if ready:
                        self.handle(*self.udp.recvfrom(65536))
                    for session in list(self.sessions.values()):
                        timeout = session.silence * (0.5 if "evicts_early" in self.wrong else 1)
                        if time.monotonic() - session.alive > timeout:
                            self.end_session(session, "evicted", "silent")
            except (OSError, ValueError):
                return  # closed

    def handle(self, datagram, address):
        self.count("datagrams")
        self.arrived.append(datagram)
        try:
            self.receive(datagram, address)
        except Dropped as dropped:
            self.count(f"dropped.{dropped}")
            if "answers_dropped" in self.wrong and self.sessions:
                session = next(iter(self.sessions.values()))
                if session.last:
                    self.udp.sendto(session.reply((0.0, 0.0, 0.0), 0, time.monotonic_ns()), address)

    def check_header(self, head):
        tests = [("magic", head.magic != b"FW" and "any_magic" not in self.wrong), ("version", head.version != 1 and "any_version" not in self.wrong),
                 ("kind", head.kind not in (1, 3, 4) and "any_kind" not in self.wrong), ("reserved", head.reserved != 0 and "reserved_ignored" not in self.wrong)]
        for name, fails in reversed(tests) if "header_backwards" in self.wrong else tests:
            if fails:
                raise Dropped(name)

    def receive(self, datagram, address):
        """The checks of the text in their order, then the answer."""
        received = time.monotonic_ns()
        if not 40 <= len(datagram) <= (1100 if "short_limit" in self.wrong else 1200):
            raise Dropped("size")
        head = sealing.Head(datagram)
        self.check_header(head)
        session = self.sessions.get(head.session)
        if session is None and "any_session" in self.wrong and self.sessions:
            session = next(iter(self.sessions.values()))
        if session is None:
            if head.kind == sealing.GOODBYE and head.session in self.ended and "late_goodbye_dropped" not in self.wrong:
                self.count("late_goodbyes")
                return
            raise Dropped("session")
        session.check_number(head.packet)
        payload = session.open(datagram, head.packet)
        session.keep_number(head.packet)
        if head.kind == 4:
            raise Dropped("malformed" if "states_malformed" in self.wrong else "kind")
        try:
            if len(payload) < 8:
                raise flat.Malformed("short")
            table = flat.read(DATAGRAM, "Goodbye" if head.kind == sealing.GOODBYE else "Samples", payload)
            if head.kind == sealing.GOODBYE and table.reason > 5 and "any_reason" not in self.wrong:
                raise flat.Malformed("reason")
        except flat.Malformed as error:
            if "forgets_number" in self.wrong:
                session.seen.discard(head.packet)
            raise Dropped("malformed") from error
        self.datagrams.append((time.monotonic(), session, head, table, datagram))
        if head.kind == sealing.GOODBYE:
            self.end_session(session, "leaving", "left", goodbye="goodbye_answered" in self.wrong)
            return
        fresh = max(1, sum(one["index"] > session.newest for one in table.samples))
        if session.check_rate(fresh):
            self.end_session(session, "flooding", "flooded")
            return
        if "stale_is_life" in self.wrong:
            session.alive = time.monotonic()
        if "goodbye_to_any" in self.wrong:
            session.address = address
        session.check_samples(table)
        self.take(session, head, table, address, received)

    def take(self, session, head, table, address, received):
        session.alive = time.monotonic()
        if head.packet > session.address_packet:
            session.address, session.address_packet = address, head.packet
        number, gap, missing = session.take(table)
        for name, value in (("samples", number), ("gaps", gap), ("missed", missing)):
            self.count(name, value)
        force = session.command()
        if "hands_mixed" in self.wrong:
            others = [other for other in self.sessions.values() if other.last and other is not session]
            force = (0.0, 0.0, force[2] + sum(other.command()[2] for other in others))
        if session.withholds(force, gap):
            session.withheld += 1
            self.count("withheld")
            return
        view = self.view() if session.role == "observer" or "view_for_all" in self.wrong else None
        more = self.answer(session, table) if self.answer else {}
        if isinstance(more, dict):
            more = [session.reply(more.pop("force", force), gap, received, view, **more)]
        to = session.first_address = getattr(session, "first_address", address)
        for one in more:
            self.udp.sendto(one, to if "first_address" in self.wrong else address)
            if "replies_twice" in self.wrong:
                self.udp.sendto(session.reply(force, gap, received), address)
        self.count("replies", len(more))

    def view(self):
        hands = [{"position": tuple(one.last["position"].values()), "orientation": (1, 0, 0, 0), "number": number + 1}
                 for number, one in enumerate(self.sessions.values()) if one.role != "observer" and one.last]
        return {"hands_from": 0, "hands_end": 2**32 - 1, "bodies_end": 2**16 - 1, "hands": hands}

    # The control port.
    def _accept(self):
        while self.running:
            try:
                sock, _ = self.listener.accept()
            except OSError:
                return
            self.connections += 1
            self._start(self._serve_connection, sock)

    def _serve_connection(self, sock):
        Control.set_patience(sock, 60)
        try:
            tls = openssl.Tls(sock, self.identity, openssl.TLS12 if "tls12" in self.wrong else self.version)
        except (openssl.Closed, openssl.Silent):
            sock.close()
            return
        connection = Connection(self, tls)
        try:
            while self.running and connection.serve():
                pass
        except (openssl.Closed, openssl.Silent):
            pass
        if "session_of_connection" in self.wrong:
            with self.lock:
                for number in connection.joined:
                    self.sessions.pop(number, None)
        tls.close()


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
        return getattr(self, "on_" + name)(value)

    def authenticate(self, value):
        for role, token in self.server.tokens.items():
            if value.token == token:
                self.role, self.client = {"other": "operator"}.get(role, role), f"{role}-client"
                told = "operator" if "role_hidden" in self.server.wrong else self.role
                return "Authenticated", {"client": self.client, "scene": "*", "role": ROLES[told]}
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
        number = secrets.randbits(64) | 1
        if "one_session" in server.wrong and server.sessions:
            number = next(iter(server.sessions))
        suite = server.suite or (1 if value.aes_256_gcm or "always_aes" in server.wrong else 2)
        parameters = dict(value.parameters)
        if "hold_lengthened" in server.wrong:
            parameters["hold_time"] = min(1.0, 2 * parameters["hold_time"])
        answer = server.grant({"session": number, "port_offset": 1, "parameters": parameters, "silence_timeout": server.silence_timeout,
                               "start_normal": (0.0, 0.0, 1.0), "start_position": (0.0, 0.0, 0.0), "stiffness": 600.0, "suite": suite})
        if answer["session"]:
            server.sessions[number] = Session(number, self.client, role, answer["parameters"], self.tls, suite, server.silence_timeout,
                                              server.wrong)
            self.joined.append(number)
            server.count("sessions_served")
        return "JoinAccepted", answer

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
            if new != old and not (new != new and old != old) and name != "velocity_cutoff" and "sets_all" not in self.server.wrong:
                raise Refusal("not_supported" if name in ("mode", "projection", "storage") else "bad_parameters", name)
        session.parameters = dict(value.parameters)
        return "ParametersSet", {"session": value.session, "parameters": session.parameters}

    def on_SetLink(self, value):
        self.session(value.session)
        if "asks_unasked" in self.server.wrong:
            self.server.answer = lambda session, table: {"change": {"number": 1, "link": (value.delay, value.jitter, value.loss)}}
            return "SceneChanged", {"scene": "plane", "what": "the link"}
        raise Refusal("not_supported", "the client takes no other link")

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

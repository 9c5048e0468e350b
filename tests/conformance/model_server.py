"""A server in Python, made from PROTOCOL.md: sessions of one scene, the control port and the scene's port.

It is the server that the client's checks talk to, and, with deviations (`wrong`), the mutants that the server's checks must find.
`grant`, `answer` and `heard` let a check change what it grants, change what it answers, and see what came.
"""
import secrets
import select
import socket
import threading
import time

import flat
import model_admin
import tls13
import sealing
from control import ROLES, VERSIONS, Control
from model_control import Connection
from model_session import Dropped
from schema import DATAGRAM

class ModelServer:
    host = "127.0.0.1"
    has = ("changes", "materials", "limits", "models")
    most_sessions, burst = model_admin.OF_THE_SCENE, model_admin.BURST

    def __init__(self, wrong=(), silence=4.0, suite=None, roles=("observer", "pointer", "operator", "admin", "other"), version=tls13.TLS13):
        self.wrong, self.silence_timeout, self.scene, self.suite, self.version = set(wrong), silence, "plane", suite, version
        self.identity = tls13.Identity()
        self.fingerprint = self.identity.fingerprint
        self.tokens = {role: f"fw_{secrets.token_hex(6)}_{secrets.token_hex(32)}" for role in roles}
        self.sessions, self.ended, self.counts = {}, [], {}
        self.stiffness, self.scene_version, self.changes, self.hands, self.questions = 600.0, 1, 0, 0, {}
        self.requests, self.arrived, self.datagrams, self.connections = [], [], [], 0
        self.versions = dict(VERSIONS)  # that it tells
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
                 ("kind", head.kind not in (1, 3, 4) and "any_kind" not in self.wrong),
                 ("reserved", head.reserved != 0 and "reserved_ignored" not in self.wrong)]
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
        session.tell(table.report, table.times)
        force = session.command(self.stiffness)
        if "hands_mixed" in self.wrong:
            others = [other for other in self.sessions.values() if other.last and other is not session]
            force = (0.0, 0.0, force[2] + sum(other.command(self.stiffness)[2] for other in others))
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
        sock.settimeout(60)
        try:
            tls = tls13.Tls(sock, self.identity, tls13.TLS12 if "tls12" in self.wrong else self.version)
        except (tls13.Closed, tls13.Silent):
            sock.close()
            return
        connection = Connection(self, tls)
        try:
            while self.running and connection.serve():
                pass
        except (tls13.Closed, tls13.Silent):
            pass
        if "session_of_connection" in self.wrong:
            with self.lock:
                for number in connection.joined:
                    self.sessions.pop(number, None)
        tls.close()

"""A session as its client has it: joins by a control connection, seals samples, opens replies. It has no law and no device."""
import select
import socket
import time

import flat
import patience
import sealing
from checks import TIMED_OUT, Failure
from control import Control, join_request
from schema import DATAGRAM


class Hand:
    """`tell` makes a datagram of samples, `send` sends bytes, `reply` waits for the next answer."""

    def __init__(self, server, role="operator", scene=None, token=None, parameters=None, device=None, control=None, **more):
        self.server = server
        self.control = control or Control(server, token or server.token(role))
        scene = scene or server.scene
        if role != "operator":
            more.setdefault("role", server.role_number(role))
        self.joined = self.control.ask("JoinRequest", **join_request(scene, device, parameters, **more))
        self.session, self.suite = self.joined.session, self.joined.suite
        self.up, self.down = sealing.keys_of(self.joined)
        self.port = server.port + self.joined.port_offset
        self.packet, self.index, self.time = 0, 0, time.monotonic_ns()
        self.socket = self.new_socket()
        self.heads = []  # of all datagrams that came

    def new_socket(self):
        sock = socket.socket(socket.AF_INET, socket.SOCK_DGRAM)
        sock.bind(("127.0.0.1", 0))
        return sock

    def next_packet(self):
        self.packet += 1
        return self.packet

    def sample(self, position=(0.0, 0.0, 0.1), index=None, **fields):
        """The next sample, or that of an index."""
        if index is None:
            self.index += 1
            index = self.index
        return {"index": index, "client_time": self.time + index * 1_000_000, "position": position, **fields}

    def payload(self, samples, **fields):
        return flat.write(DATAGRAM, "Samples", {"samples": samples, **fields})

    def seal(self, payload, kind=sealing.SAMPLES, packet=None, session=None, **head):
        """A datagram of these bytes."""
        packet = self.next_packet() if packet is None else packet
        return self.up.seal(sealing.header(kind, self.session if session is None else session, packet, **head), payload)

    def tell(self, *positions, **fields):
        """A datagram of new samples, the last position the newest."""
        samples = [self.sample(position) for position in positions or [(0.0, 0.0, 0.1)]]
        return self.seal(self.payload(samples[::-1], **fields))

    def send(self, datagram, sock=None):
        (sock or self.socket).sendto(datagram, (self.server.host, self.port))
        return datagram

    def goodbye(self, reason=0):
        return self.send(self.seal(flat.write(DATAGRAM, "Goodbye", {"reason": reason}), kind=sealing.GOODBYE))

    def datagram(self, seconds=None, sock=None):
        """The next datagram as it came; None if there is none in time."""
        sock, seconds = sock or self.socket, patience.LONGEST if seconds is None else seconds
        if not select.select([sock], [], [], seconds)[0]:
            return None
        return sock.recv(65536)

    def read(self, datagram):
        """(head, table) of a datagram of the server; raises if the text does not allow it."""
        head = sealing.Head(datagram)
        self.heads.append((head, len(datagram)))
        payload = self.down.open(datagram)
        if payload is None:
            raise flat.Malformed("the seal of the server's datagram is wrong")
        return head, flat.read(DATAGRAM, {2: "Reply", 3: "Goodbye"}.get(head.kind, "?"), payload)

    def reply(self, seconds=None, sock=None):
        """(head, table) of the next datagram; None if there is none in time."""
        datagram = self.datagram(seconds, sock)
        return None if datagram is None else self.read(datagram)

    def ask(self, *positions, sock=None, **fields):
        """The reply to one datagram of new samples."""
        self.send(self.tell(*positions, **fields), sock)
        answer = self.reply(sock=sock)
        if answer is None:
            raise Failure(f"{TIMED_OUT} {patience.LONGEST} s: a reply")
        return answer[1]

    def close(self, leave=True):
        """Ends the session, so that the next check finds none."""
        try:
            if leave:
                self.control.ask_any("LeaveRequest", session=self.session)
            self.control.close()
        except Exception:  # the check may have closed it
            pass
        self.socket.close()

"""Control connections: frames of ControlMessage over TLS, the client's end (PROTOCOL.md, "Control (TLS)")."""
import socket
import struct

import flat
import patience
import tls13
from schema import CONTROL

CODES = CONTROL.enums["RefusalCode"].values
ROLES = CONTROL.enums["Role"].values
SIDES = CONTROL.enums["BoundingSide"].values

VERSIONS = {"newest_protocol": 2, "oldest_protocol": 2}  # that these checks and models speak
DEVICE = {"name": "probe", "damping": 5.0, "apparent_mass": 0.1, "position_resolution": 1e-5, "max_force": 8.0, "continuous_force": 3.0,
          "workspace": (0.3, 0.3, 0.3)}
PARAMETERS = {"mode": "none", "side": SIDES["client"], "redundancy": 0}


def frame(body):
    """A frame with one request or answer: (name, fields)."""
    contents = flat.write(CONTROL, "ControlMessage", {"body": body})
    return struct.pack("<I", len(contents)) + contents


def read_frame(tls):
    size = struct.unpack("<I", tls.receive(4))[0]
    return flat.read(CONTROL, "ControlMessage", tls.receive(size))["body"]


class Control:
    """A connection to a server's control port. With a token it authenticates at once."""

    def __init__(self, server, token=None, version=tls13.TLS13):
        sock = socket.create_connection((server.host, server.port), timeout=patience.LONGEST)
        self.server = server
        try:
            self.tls = tls13.Tls(sock, version=version)
        except Exception:
            sock.close()
            raise
        if token is not None:
            self.identity = self.ask("Authenticate", token=token, **VERSIONS)

    def patience(self, seconds):
        self.tls.patience(seconds)

    def ask_any(self, name, **fields):
        """The answer of any kind, as (name, value)."""
        self.tls.send(frame((name, fields)))
        return read_frame(self.tls)

    def ask(self, name, **fields):
        """The answer; raises Refused if it is one."""
        kind, value = self.ask_any(name, **fields)
        if kind == "Refused":
            raise Refused(value.code, value.reason)
        return value

    def raw(self, data):
        """The answer to these bytes."""
        self.tls.send(data)
        return read_frame(self.tls)

    def closes(self):
        """The server closes the connection, within the patience."""
        try:
            self.tls.receive(1)
        except tls13.Closed:
            return True
        except tls13.Silent:
            return False
        return False

    def close(self):
        self.tls.close()


class Refused(Exception):
    def __init__(self, code, reason):
        self.code = {number: name for name, number in CODES.items()}.get(code, code)
        self.reason = reason
        super().__init__(f"refused {self.code}: {reason}")


def join_request(scene, device=None, parameters=None, **more):
    return {"client": "checker", "scene": scene, "device": {**DEVICE, **(device or {})},
            "parameters": {**PARAMETERS, **(parameters or {})}, "aes_256_gcm": True, **more}

"""An admin of a server that runs: docs/admin.md."""
import ctypes
import json

from . import abi
from .access import set_access
from .handle import Handle, _raise
from .library import BLOCKING
from .options import word, words as words_of
from .values import name_bytes


def admin(server, *, token_file=None, fingerprint=None, fingerprint_file=None, ca_file=None, certificate_file=None, key_file=None):
    """Returns an Admin of the server "HOST:PORT". Credentials as in feltwire.join(), with a token of the role admin. Blocks until the
    server has answered. Raises ValueError for a wrong option, Refused, or ServerError."""
    given = abi.AdminOptions()
    BLOCKING.fw_admin_options_default(given, ctypes.sizeof(given))
    set_access(given, server, token_file, fingerprint, fingerprint_file, ca_file, certificate_file, key_file)
    handle = ctypes.c_void_p()
    result = BLOCKING.fw_admin_open(given, handle)
    if result != abi.OK:
        _raise(result)
    return Admin(handle)


class Admin(Handle):
    """Lists and changes what runs on a server. Use it in a `with` block, or call close(). Each call is a command of `feltwire-client admin`:
    it blocks until the server has answered, and raises ValueError for wrong words, Refused, or ServerError. Any thread may call it.

    scene: a name; None: the only scene of the server, or for lists all of them.
    """

    NAME = "admin"
    AIO = "use feltwire.aio.admin(server.address, ...)"

    def request(self, *words):
        """Runs a command with the words of `feltwire-client admin`: request("set", "--object", "table", "--stiffness", 500). Returns its
        answer with --json as lists and dictionaries."""
        encoded = [name_bytes(word(one)) for one in words]
        answer = ctypes.c_char_p()
        with self._lock:
            result = BLOCKING.fw_admin_request(self._open(), (ctypes.c_char_p * len(encoded))(*encoded), len(encoded), answer)
            if result != abi.OK:
                _raise(result)
            return json.loads(answer.value)

    def _request(self, *words, **options):
        return self.request(*words, *words_of(options))

    def scenes(self):
        """A dictionary for each scene that the token opens: scene, port, objects, clients."""
        return self.request("scenes")

    def sessions(self, scene=None):
        """A dictionary for each session: scene, number, session (its id), client, device, role, mode, loss, round_trip_ms and more."""
        return self._request("sessions", scene=scene)

    def stats(self):
        """The counters of the control port and of each scene."""
        return self.request("stats")

    def set(self, **options):
        """Changes what `admin set` changes, with _ for -: set(object="table", stiffness=500), set(gravity=(0, 0, -1.62)),
        set(session=1, mode="contact_frame"), set(session=1, delay=25, loss=10), set(session=1, lead_share=0.5)."""
        return self._request("set", **options)

    def evict(self, session, scene=None):
        """Ends a session, by its number in the scene or by its id."""
        return self._request("evict", session, scene=scene)

    def reload(self, scene):
        """Reads the scene's file again."""
        return self._request("reload", scene)

    def record(self, scene=None):
        """Writes the last ten seconds of a scene, or of all, to files on the server's machine. Returns a dictionary for each: scene, file."""
        return self._request("record", scene=scene)

    def close(self):
        """Forgets the credentials. May be called again."""
        super().close()

"""An observer of a scene: it has no hand, and sees all hands and moving bodies."""
import ctypes
import threading

from . import abi
from .access import set_access
from .handle import Handle, _raise, messages_of
from .library import BLOCKING, QUICK
from .values import name_or_none

_STATE_SIZE = ctypes.sizeof(abi.SceneState)
_LONGEST_NAME = 256
_STEP = 0.1  # [s] Python looks for Ctrl-C between two calls


def observe(server, scene, *, name="python", period=0.01, patience=30.0, token_file=None, fingerprint=None, fingerprint_file=None,
            ca_file=None, certificate_file=None, key_file=None):
    """Joins a scene as an observer and returns its Observer. Blocks until the server has answered.

    server: "HOST:PORT". scene: its name. period [s]: between two views of the scene. A view tells of 6 hands, so with 16 hands each is
    told in every third view. patience [s]: for which a lost session is looked for; 0: not at all. Credentials as in feltwire.join(); a
    token of any role that opens the scene will do.

    Raises ValueError for a wrong option, Refused, ServerError, or Error.
    """
    given = abi.ObserverOptions()
    BLOCKING.fw_observer_options_default(given, ctypes.sizeof(given))
    set_access(given, server, token_file, fingerprint, fingerprint_file, ca_file, certificate_file, key_file)
    given.scene, given.name, given.period, given.patience = name_or_none(scene), name_or_none(name), period, patience
    handle = ctypes.c_void_p()
    result = BLOCKING.fw_observer_open(given, handle)
    if result != abi.OK:
        _raise(result)
    return Observer(handle)


class _List:
    """The structs of one of the library's lists, as an array."""

    def __init__(self, call, struct, dtype):
        self._call, self._struct, self._dtype, self._room = call, struct, dtype, (struct * 0)()
        try:
            import numpy
            self._numpy, self._dtype = numpy, numpy.dtype(dtype)
        except ImportError:
            self._numpy = None

    def read(self, handle, most):
        """most: how many there are."""
        if most > len(self._room):
            self._room = (self._struct * (most + 16))()
        count = ctypes.c_uint32()
        result = self._call(handle, self._room, ctypes.sizeof(self._struct), len(self._room), count)
        if result < 0:
            _raise(result)
        if self._numpy is None:
            return [self._struct.from_buffer_copy(one) for one in self._room[:count.value]]
        if count.value == 0:
            return self._numpy.empty(0, self._dtype)
        return self._numpy.frombuffer(self._room, self._dtype, count.value).copy()


class Observer(Handle):
    """An observer. Use it in a `with` block, or call close(). Iterate over it to get each newer state:

        for state in observer:
            print(state.time, observer.hands()["position"])
    """

    NAME = "observer"
    AIO = "use feltwire.aio.observe(server.address, scene, ...)"

    def __init__(self, handle):
        super().__init__(handle)
        self._state = abi.SceneState()
        self._asked, self._counted = abi.SceneState(), abi.SceneState()  # for the object itself
        self._hands = _List(QUICK.fw_observer_hands, abi.SeenHand, abi.SEEN_HAND_DTYPE)
        self._bodies = _List(QUICK.fw_observer_bodies, abi.SeenBody, abi.SEEN_BODY_DTYPE)

    def renew_locks(self):
        self._lock = threading.RLock()  # of calls that let other Python threads run
        self._lists = threading.Lock()  # of the room of both lists

    def __iter__(self):
        """Each newer state, until the observer has ended. Where the program is slow, states between are left out."""
        number = 0
        while self.wait(after=number):
            state = self.latest()
            number = state.number
            yield state

    def latest(self):
        """The newest state, or None before the first view: number, time [s], age [s], hands, bodies, connected, left_out. The next call
        overwrites it."""
        return self._newest(self._state)

    def _newest(self, state):
        result = QUICK.fw_observer_latest(self._open(), state, _STATE_SIZE)
        if result < 0:
            _raise(result)
        return state if result == abi.OK else None

    def hands(self):
        """The hands of the newest state, by rising number: a NumPy array with a field for each value (hands["position"] is n x 3), or a
        list where NumPy is not installed. Fields: number, states, time, position, orientation, force, commanded, proxy, depth, delivered,
        burned, balance, round_trip, samples, missed, tool."""
        with self._lists:
            state = self._newest(self._counted)
            return self._hands.read(self._open(), 0 if state is None else state.hands)

    def bodies(self):
        """The moving bodies, by rising object, as hands() gives its values: object, time, position, orientation."""
        with self._lists:
            state = self._newest(self._counted)
            return self._bodies.read(self._open(), 0 if state is None else state.bodies)

    def name(self, number):
        """The name that the client of a hand gives itself; None: it is not known yet, or there is no such hand."""
        room = ctypes.create_string_buffer(_LONGEST_NAME)
        with self._lock:
            result = BLOCKING.fw_observer_hand_name(self._open(), int(number), room, len(room))
        if result < 0:
            _raise(result)
        return room.value.decode(errors="replace") if result == abi.OK else None

    def messages(self):
        """What happened to the session since the last call: it was lost, or is there again."""
        return messages_of(self, BLOCKING.fw_observer_message)

    def wait(self, timeout=1e6, after=None):
        """Waits for a state with a number greater than `after` (None: than that of the newest), at most `timeout` [s]. Returns whether
        there is one; False also where the observer has ended. Ctrl-C interrupts it."""
        if after is None:
            after = self._number()
        while True:
            result = self._look(after, max(0.0, min(_STEP, timeout)))
            timeout -= _STEP
            if result != abi.NOTHING or timeout <= 0.0:
                return result == abi.OK

    def _number(self):
        """That of the newest state."""
        state = self._newest(self._asked)
        return 0 if state is None else state.number

    def _look(self, after, timeout):
        """abi.OK: there is a newer state, within `timeout` [s]; abi.NOTHING: not yet; abi.ENDED: there will be none."""
        with self._lock:
            result = BLOCKING.fw_observer_wait(self._open(), after, timeout)
        if result < 0:
            _raise(result)
        return result

    def close(self):
        """Leaves the scene. Raises Error if an error had ended the observer. May be called again."""
        with self._lock, self._lists:
            super().close()

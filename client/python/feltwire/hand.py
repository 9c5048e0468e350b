"""A hand in a scene."""
import ctypes
import os
import threading

from . import abi
from .library import BLOCKING, QUICK

_TICK_SIZE = ctypes.sizeof(abi.Tick)
_MOST_TICKS = 1 << 14


class Error(RuntimeError):
    """Something failed. The text says what, and the remedy."""


class Refused(Error):
    """The server refuses for good: the token, the scene, the device or a parameter."""


class ServerError(Error):
    """The server is not reachable, not trusted, or full. Trying again may help."""


def _raise(result):
    text = BLOCKING.fw_last_error().decode(errors="replace")
    if result == abi.ERROR_ARGUMENT:
        raise ValueError(text)
    if result == abi.ERROR_MEMORY:
        raise MemoryError(text)
    kind = {abi.ERROR_REFUSED: Refused, abi.ERROR_SERVER: ServerError}.get(result, Error)
    raise kind(text or BLOCKING.fw_result_text(result).decode())


def _words(options):
    """{"path": "press", "local_model": False} -> ["--path", "press", "--no-local-model"]"""
    words = []
    for name, value in options.items():
        option = name.replace("_", "-")
        if value is True or value is False:
            words.append(f"--{option}" if value else f"--no-{option}")
        elif value is not None:
            joined = ",".join(str(one) for one in value) if isinstance(value, (list, tuple)) else str(value)
            words += [f"--{option}", joined]
    return words


def _bytes(text):
    return None if text is None else os.fsencode(text)


def join(server, scene, *, device="simulated", spec=None, name="python", token_file=None, fingerprint=None, fingerprint_file=None,
         ca_file=None, duration=0.0, stale_after=0.02, **options):
    """Joins a scene and returns its Hand. Blocks until the server has answered.

    server: "HOST:PORT". scene: its name. device: as --device of feltwire-client, or "caller": the program is the device, by Hand.exchange().
    spec: a built-in specification of the device, or the path of a JSON file. duration [s]: when the run ends; 0: at Hand.close().
    stale_after [s]: a hand of device "caller" that was not moved for so long gets no force. The server is recognised by fingerprint,
    fingerprint_file or ca_file; without any by FELTWIRE_FINGERPRINT_FILE. token_file: without it FELTWIRE_TOKEN_FILE.

    All other keywords are options of feltwire-client with _ for -: path="press", record="a.mcap", max_force=3.

    Raises ValueError for a wrong option, Refused, ServerError, or Error.
    """
    if fingerprint is None and fingerprint_file is None and ca_file is None:
        fingerprint_file = os.environ.get("FELTWIRE_FINGERPRINT_FILE")
    if token_file is None:
        token_file = os.environ.get("FELTWIRE_TOKEN_FILE")
    given = abi.HandOptions()
    BLOCKING.fw_hand_options_default(given, ctypes.sizeof(given))
    given.server, given.scene, given.device, given.name = _bytes(server), _bytes(scene), _bytes(device), _bytes(name)
    given.spec, given.fingerprint, given.ca_file = _bytes(spec), _bytes(fingerprint), _bytes(ca_file)
    given.fingerprint_file, given.token_file = _bytes(fingerprint_file), _bytes(token_file)
    given.duration, given.stale_after = duration, stale_after
    words = [os.fsencode(word) for word in _words(options)]
    more = (ctypes.c_char_p * max(len(words), 1))(*words)
    given.more, given.more_count = more, len(words)
    handle = ctypes.c_void_p()
    result = BLOCKING.fw_hand_open(given, handle)
    if result != abi.OK:
        _raise(result)
    return Hand(handle)


class Hand:
    """A hand that has joined a scene. Use it in a `with` block, or call close()."""

    def __init__(self, handle):
        self._handle = handle
        self._lock = threading.Lock()  # of the calls that give other threads the interpreter
        self._tick, self._exchanged, self._asked = abi.Tick(), abi.Tick(), abi.Tick()
        self._room = None  # of ticks()
        self._pose = abi.Pose()
        BLOCKING.fw_pose_default(self._pose, ctypes.sizeof(self._pose))
        self.session = abi.Session()
        """What the server granted: servo_period [s], hold_time [s], stiffness [N/m], start_position [m], start_normal."""
        BLOCKING.fw_hand_session(handle, self.session, ctypes.sizeof(self.session))

    def _open(self):
        if self._handle is None:
            raise ValueError("the hand is closed")
        return self._handle

    def __enter__(self):
        return self

    def __exit__(self, kind, *_):
        try:
            self.close()
        except Error:
            if kind is None:
                raise

    def exchange(self, position, orientation=(1.0, 0.0, 0.0, 0.0), buttons=0, deadman=False):
        """For a hand of device "caller": gives the pose of the hand, position [m] and orientation as a unit quaternion w, x, y, z.
        Returns the force [N] and torque [N m] that the program applies until its next call, each three numbers; None: the run has
        ended, and nothing may be applied."""
        pose, tick = self._pose, self._exchanged
        pose.position[:] = position
        pose.orientation[:] = orientation
        pose.buttons, pose.deadman = buttons, deadman
        result = QUICK.fw_hand_exchange(self._open(), pose, tick, _TICK_SIZE)
        if result < 0:
            _raise(result)
        return None if result == abi.ENDED else (tuple(tick.force), tuple(tick.torque))

    def latest(self):
        """The newest tick, or None before the first: time [s], position [m], orientation, force [N], torque [N m], reply_age [s],
        balance [J], account_cut, zero_force_reason, connected. The next call overwrites it."""
        return self._newest(self._tick)

    def _newest(self, tick):
        result = QUICK.fw_hand_latest(self._open(), tick, _TICK_SIZE)
        if result < 0:
            _raise(result)
        return tick if result == abi.OK else None

    def ticks(self):
        """The ticks since the last call: a NumPy array with a field for each number (ticks["force"] is n x 3), or a list of ticks where
        NumPy is not installed. The library keeps 16384 of them: after more without a call the newest are lost, and their numbers
        tell it."""
        if self._room is None:
            self._room = (abi.Tick * _MOST_TICKS)()
        count = ctypes.c_uint32()
        result = QUICK.fw_hand_ticks(self._open(), self._room, _TICK_SIZE, _MOST_TICKS, count)
        if result < 0:
            _raise(result)
        try:
            import numpy
        except ImportError:
            return [abi.Tick.from_buffer_copy(tick) for tick in self._room[:count.value]]
        return numpy.frombuffer(self._room, dtype=numpy.dtype(abi.TICK_DTYPE), count=_MOST_TICKS)[:count.value].copy()

    def why_no_force(self):
        """Why the newest force is zero, in words; empty if it is not."""
        tick = self._newest(self._asked)
        return "" if tick is None else QUICK.fw_zero_force_text(tick.zero_force_reason).decode()

    def messages(self):
        """The warnings and notes since the last call."""
        room, found = ctypes.create_string_buffer(4096), []
        with self._lock:
            while BLOCKING.fw_hand_message(self._open(), room, len(room)) == abi.OK:
                found.append(room.value.decode(errors="replace"))
        return found

    def wait(self, timeout=1e6):
        """Waits until the run has ended, at most `timeout` [s]. Returns whether it has. Ctrl-C interrupts it."""
        step = 0.1  # [s] Python looks for Ctrl-C between two calls
        while timeout > 0.0:
            with self._lock:
                result = BLOCKING.fw_hand_wait(self._open(), min(step, timeout))
            if result < 0:
                _raise(result)
            if result == abi.ENDED:
                return True
            timeout -= step
        return False

    def stop(self):
        """Lets the force fade and ends the run. Does not wait."""
        with self._lock:
            BLOCKING.fw_hand_stop(self._open())

    def close(self):
        """Ends the run, and leaves the scene. Raises Error if an error had ended the run. May be called again."""
        with self._lock:
            handle, self._handle = self._handle, None
            if handle is None:
                return
            result = BLOCKING.fw_hand_close(handle)
        if result != abi.OK:
            _raise(result)

    def __del__(self):
        handle, self._handle = getattr(self, "_handle", None), None
        if handle is not None:
            BLOCKING.fw_hand_close(handle)

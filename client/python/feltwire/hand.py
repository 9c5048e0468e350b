"""A hand in a scene."""
from __future__ import annotations

import ctypes
import functools
import warnings
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence, Tuple

from . import abi
from .access import set_access
from .handle import Handle, _raise, messages_of
from .library import BLOCKING, QUICK
from .options import words as _words
from .tables import numpy_or_none
from .values import Path, name_or_none, path_or_none, set_number, set_vector, text_bytes

if TYPE_CHECKING:
    from .recorder import Recorder

_TICK_SIZE = ctypes.sizeof(abi.Tick)
_MOST_TICKS = 1 << 14
_WORTH_KEEPING = _MOST_TICKS // 4  # ticks from which on an array keeps the whole room, and is no copy


def set_hand(given: Any, device: str, spec: Optional[Path], name: str, duration: float, stale_after: float, options: Dict[str, Any]) -> None:
    """Sets what the options of all hands have, as join() describes it."""
    given.device, given.name, given.spec = path_or_none(device), name_or_none(name), path_or_none(spec)
    set_number(given, "duration", duration, "duration", " [s]")
    set_number(given, "stale_after", stale_after, "stale_after", " [s]")
    more = [text_bytes(word) for word in _words(options)]
    given.more, given.more_count = (ctypes.c_char_p * max(len(more), 1))(*more), len(more)


def join(server: str, scene: str, *, device: str = "simulated", spec: Optional[Path] = None, name: str = "python",
         token_file: Optional[Path] = None, fingerprint: Optional[str] = None, fingerprint_file: Optional[Path] = None,
         ca_file: Optional[Path] = None, duration: float = 0.0, stale_after: float = 0.02, **options: Any) -> Hand:
    """Joins a scene and returns its Hand. Blocks until the server has answered.

    server: "HOST:PORT". scene: its name. device: as --device of feltwire-client, "caller": the program is the device, by Hand.exchange(), or "stepped": by Hand.step().
    spec: a built-in specification of the device, or the path of a JSON file. duration [s]: when the run ends; 0: at Hand.close().
    stale_after [s]: a hand of device "caller" that was not moved for so long gets no force. The server is recognised by fingerprint,
    fingerprint_file or ca_file; without any by FELTWIRE_FINGERPRINT_FILE. token_file: without it FELTWIRE_TOKEN_FILE.

    All other keywords are options of feltwire-client with _ for -: record="a.mcap", max_force=3.

    Raises ValueError for a wrong option, Refused, ServerError, or Error.
    """
    given = abi.HandOptions()
    BLOCKING.fw_hand_options_default(given, ctypes.sizeof(given))
    set_access(given, server, token_file, fingerprint, fingerprint_file, ca_file)
    given.scene = name_or_none(scene)
    set_hand(given, device, spec, name, duration, stale_after, options)
    handle = ctypes.c_void_p()
    result = BLOCKING.fw_hand_open(given, handle)
    if result != abi.OK:
        _raise(result)
    return Hand(handle)


class Hand(Handle):
    """A hand that has joined a scene. Use it in a `with` block, or call close()."""

    NAME = "hand"
    AIO = "join by feltwire.aio.join(server.address, scene, ...)"

    def __init__(self, handle: ctypes.c_void_p):
        super().__init__(handle)
        self._tick, self._exchanged, self._asked = abi.Tick(), abi.Tick(), abi.Tick()
        # Without types, ctypes converts no argument anew at each call of latest(): that saves a third of its time.
        call = QUICK["fw_hand_latest"]
        call.restype = ctypes.c_int32
        self._latest: Callable[[], int] = functools.partial(call, handle, ctypes.byref(self._tick), ctypes.c_uint32(_TICK_SIZE))
        self._room: Any = None  # of ticks()
        self._pose = abi.Pose()
        BLOCKING.fw_pose_default(self._pose, ctypes.sizeof(self._pose))
        self.session = abi.Session()
        """What the server granted: servo_period [s], hold_time [s], stiffness [N/m], start_position [m], start_normal."""
        BLOCKING.fw_hand_session(handle, self.session, ctypes.sizeof(self.session))

    def exchange(self, position: Sequence[float], orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0), buttons: int = 0,
                 deadman: bool = False, gripper: float = -1.0) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
        """For a hand of device "caller": gives the pose of the hand, position [m] and orientation as a unit quaternion w, x, y, z. A hand with
        lead=0.2 leads the robot of the scene while deadman, its enabling switch, is held; gripper [m] is the wanted opening, below 0 none.
        Returns the force [N] and torque [N m] that the program applies until its next call, each three numbers; None: the run has
        ended, and nothing may be applied."""
        return self._moved(QUICK.fw_hand_exchange, position, orientation, buttons, deadman, gripper)

    def step(self, position: Sequence[float], orientation: Sequence[float] = (1.0, 0.0, 0.0, 0.0), buttons: int = 0,
             deadman: bool = False, gripper: float = -1.0) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
        """For a hand of device "stepped", of a program that has a loop of its own: makes a tick with this pose, and returns its force as
        exchange() does. It blocks until the servo has made the tick. Call it `rate` times a second: a later call is a late tick to the energy
        account, and one later than a quarter of the hold time takes the force off."""
        return self._moved(BLOCKING.fw_hand_step, position, orientation, buttons, deadman, gripper)

    def _moved(self, call: Callable[..., int], position: Sequence[float], orientation: Sequence[float], buttons: int, deadman: bool,
               gripper: float) -> Optional[Tuple[Tuple[float, ...], Tuple[float, ...]]]:
        pose, tick = self._pose, self._exchanged
        set_vector(pose, "position", position, "position", " [m]")
        set_vector(pose, "orientation", orientation, "orientation", " w, x, y, z")
        pose.buttons, pose.deadman = buttons, deadman
        set_number(pose, "gripper", gripper, "gripper", " [m]")
        result = call(self._open(), pose, tick, _TICK_SIZE)
        if result < 0:
            _raise(result)
        return None if result == abi.ENDED else (tuple(tick.force), tuple(tick.torque))

    def latest(self) -> Optional[abi.Tick]:
        """The newest tick, or None before the first: time [s], position [m], orientation, force [N], torque [N m], reply_age [s],
        balance [J], account_cut, zero_force_reason, connected, scene_force [N] before the bound. The next call overwrites it."""
        return self._tick if self._latest() == abi.OK else self._newest(self._tick)

    def _newest(self, tick: abi.Tick) -> Optional[abi.Tick]:
        result = QUICK.fw_hand_latest(self._open(), tick, _TICK_SIZE)
        if result < 0:
            _raise(result)
        return tick if result == abi.OK else None

    def ticks(self) -> Any:
        """The ticks since the last call: a NumPy array with a field for each number (ticks["force"] is n x 3), or a list of ticks where
        NumPy is not installed. The library keeps 16384 of them: after more without a call the newest are lost, and their numbers
        tell it."""
        if self._room is None:
            self._room = (abi.Tick * _MOST_TICKS)()
        count = ctypes.c_uint32()
        result = QUICK.fw_hand_ticks(self._open(), self._room, _TICK_SIZE, _MOST_TICKS, count)
        if result < 0:
            _raise(result)
        if count.value == _MOST_TICKS:
            warnings.warn(f"the library keeps {_MOST_TICKS} ticks, and ticks() was not called for longer: the newest ones may be lost. Call it "
                          "more often, or record the run (record=\"hand.mcap\")", stacklevel=2)
        room, numpy = self._room, numpy_or_none()
        if numpy is None:
            return [abi.Tick.from_buffer_copy(tick) for tick in room[:count.value]]
        ticks = numpy.frombuffer(room, dtype=numpy.dtype(abi.TICK_DTYPE))[:count.value]
        if count.value < _WORTH_KEEPING:
            return ticks.copy()
        self._room = None  # The array keeps it: no copy.
        return ticks

    def record(self, file: Path, *, replace: bool = False, mebibytes: float = 0.0, seconds: float = 0.0) -> Recorder:
        """Records every tick from the next one on, until Recorder.close(), into FILE.mcap; feltwire.read() reads it.

        replace: a file that is there is replaced. mebibytes [MiB], seconds [s]: after which the next of several files begins, FILE-0001.mcap;
        0: one file. Raises ValueError if the hand is recorded already, and Error if there is such a file, or it cannot be written.
        """
        from .recorder import opened
        with self._lock:
            return opened(self._open(), file, replace, mebibytes, seconds)

    def why_no_force(self) -> str:
        """Why the newest force is zero, in words; empty if it is not."""
        if QUICK.fw_hand_wait(self._open(), 0.0) == abi.ENDED:
            return "the run has ended"
        tick = self._newest(self._asked)
        return "" if tick is None else str(QUICK.fw_zero_force_text(tick.zero_force_reason), "utf-8")

    def messages(self) -> List[str]:
        """The warnings and notes since the last call."""
        return messages_of(self, BLOCKING.fw_hand_message)

    def wait(self, timeout: float = 1e6) -> bool:
        """Waits until the run has ended, at most `timeout` [s]; 0: only asks. Returns whether it has. Ctrl-C interrupts it."""
        step = 0.1  # [s] Python looks for Ctrl-C between two calls
        while True:
            with self._lock:
                result = BLOCKING.fw_hand_wait(self._open(), max(min(step, timeout), 0.0))
            if result < 0:
                _raise(result)
            if result == abi.ENDED:
                return True
            timeout -= step
            if timeout <= 0.0:
                return False

    def stop(self) -> None:
        """Lets the force fade and ends the run. Does not wait."""
        # QUICK, and without the lock, which a thread in wait() has for 0.1 s.
        result = QUICK.fw_hand_stop(self._open())
        if result < 0:
            _raise(result)

    def close(self) -> None:
        """Ends the run, and leaves the scene. Raises Error if an error had ended the run. May be called again."""
        super().close()

    def _closing(self) -> None:
        self._latest = functools.partial(int, abi.NOTHING)

"""A recording that a program starts and stops while its hand goes on."""
from __future__ import annotations

import ctypes

from . import abi
from .handle import Handle, _raise
from .library import BLOCKING, QUICK
from .values import Path, name_bytes, path_or_none, set_number


def opened(hand: ctypes.c_void_p, file: Path, replace: bool, mebibytes: float, seconds: float) -> Recorder:
    """As Hand.record()."""
    given = abi.RecorderOptions()
    BLOCKING.fw_recorder_options_default(given, ctypes.sizeof(given))
    given.file, given.replace = path_or_none(file), bool(replace)
    set_number(given, "mebibytes", mebibytes, "mebibytes", " [MiB]")
    set_number(given, "seconds", seconds, "seconds", " [s]")
    handle = ctypes.c_void_p()
    result = BLOCKING.fw_recorder_open(hand, given, handle)
    if result != abi.OK:
        _raise(result)
    return Recorder(handle)


class Recorder(Handle):
    """A recording of a hand, of Hand.record(). Use it in a `with` block, or call close(): only then it is complete. It may be closed after the
    hand."""

    NAME = "recorder"
    AIO = "record by hand.record() of a hand of feltwire.aio"

    def mark(self, text: str) -> None:
        """Writes a text at this moment into the recording: a metadata record `mark` with `text` and `time` [ns since 1970]. Raises ValueError
        for what is no text or has no UTF-8, and Error if the file can be written no more."""
        with self._lock:
            result = BLOCKING.fw_recorder_mark(self._open(), name_bytes(text))
        if result != abi.OK:
            _raise(result)

    def state(self) -> abi.RecordingState:
        """How far it is: ticks, lost, failed. Never waits."""
        state = abi.RecordingState()
        result = QUICK.fw_recorder_state(self._open(), state, ctypes.sizeof(state))
        if result < 0:
            _raise(result)
        return state

    def close(self) -> None:
        """Writes the rest, and waits until it is on the disk. Raises Error if the recording is not complete. May be called again."""
        super().close()

"""What all objects of the library have in common: they are closed once, and by their own process."""
from __future__ import annotations

import ctypes
import re
import threading
from typing import Any, Callable, List, NoReturn, Optional, TypeVar

from . import abi
from .errors import Error, Refused, ServerError
from .forked import renew_after_fork
from .library import BLOCKING

Self = TypeVar("Self", bound="Handle")


def _in_python(text: str) -> str:
    """A text of the library, with the keywords of Python in place of options and fields of structs: --hold-time becomes hold_time."""
    text = re.sub(r"\b(?:hand|world|observer|admin|follower|recorder)_options\.(?:more: )?|\brobot_state\.", "", text)
    text = re.sub(r"(?<![\w-])--no-([a-z][a-z-]*)", lambda found: found[1].replace("-", "_") + "=False", text)
    return re.sub(r"(?<![\w-])--([a-z][a-z-]*)", lambda found: found[1].replace("-", "_"), text)


def _raise(result: int) -> NoReturn:
    text = _in_python(BLOCKING.fw_last_error().decode(errors="replace"))
    if result == abi.ERROR_ARGUMENT:
        raise ValueError(text)
    if result == abi.ERROR_MEMORY:
        raise MemoryError(text)
    kind = {abi.ERROR_REFUSED: Refused, abi.ERROR_SERVER: ServerError}.get(result, Error)
    raise kind(text or BLOCKING.fw_result_text(result).decode())


def messages_of(one: Any, call: Callable[..., int]) -> List[str]:
    """All messages that wait for a hand, an observer or a follower."""
    room, found = ctypes.create_string_buffer(4096), []
    with one._lock:
        while call(one._open(), room, len(room)) == abi.OK:
            found.append(room.value.decode(errors="replace"))
    return found


class Handle:
    """An object of the library, in use until close(). A class says its NAME, as in fw_NAME_close(), and how it is used in asyncio, if it is."""

    NAME = ""
    AIO = ""  # the call of feltwire.aio that makes the twin of this object; empty: there is none

    def __init__(self, handle: ctypes.c_void_p):
        self._handle: Optional[ctypes.c_void_p] = handle
        self.renew_locks()
        renew_after_fork(self)

    def renew_locks(self) -> None:
        self._lock: Any = threading.Lock()  # of the calls that give other threads the interpreter

    def _open(self) -> ctypes.c_void_p:
        if self._handle is None:
            raise ValueError(f"the {self.NAME} is closed")
        return self._handle

    def __enter__(self: Self) -> Self:
        return self

    async def __aenter__(self) -> NoReturn:
        self.close()
        twin = f"; for `async with` {self.AIO}" if self.AIO else ""
        raise TypeError(f"{type(self).__name__} is used with `with`{twin}")

    async def __aexit__(self, *_: object) -> None:
        """Never called: __aenter__() raises."""

    def __exit__(self, kind: Any, *_: object) -> None:
        try:
            self.close()
        except Error:
            if kind is None:
                raise

    def close(self) -> None:
        """Ends the use. Raises Error if an error had ended it. May be called again."""
        with self._lock:
            handle, self._handle = self._handle, None
            if handle is None:
                return
            self._closing()
            result = getattr(BLOCKING, f"fw_{self.NAME}_close")(handle)
        if result != abi.OK:
            _raise(result)

    def _closing(self) -> None:
        """Called once, under the lock, before the library closes it."""

    def __del__(self) -> None:
        handle, self._handle = getattr(self, "_handle", None), None
        if handle is not None:
            getattr(BLOCKING, f"fw_{self.NAME}_close")(handle)

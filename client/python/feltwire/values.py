"""Numbers and vectors of a program, for the structs of the C interface."""
from __future__ import annotations

import ctypes
import os
from typing import Any, Callable, Optional, Union

Path = Union[str, "os.PathLike[str]"]


class Struct(ctypes.Structure):
    """A struct of the C interface."""

    def __repr__(self) -> str:
        values = ((field[0], getattr(self, field[0])) for field in self._fields_ if field[0] not in ("struct_size", "reserved"))
        return f"{type(self).__name__}({', '.join(f'{name}={tuple(v) if isinstance(v, ctypes.Array) else v!r}' for name, v in values)})"


def text_bytes(text: Any, encode: Callable[[Any], bytes] = os.fsencode) -> bytes:
    """A text or a path for the library, whose texts end at a zero byte. Raises ValueError for what is neither, or has a zero byte."""
    try:
        found = encode(text)
    except (TypeError, AttributeError):
        raise ValueError(f"the library needs a text or a path, not {text!r}") from None
    if b"\0" in found:
        raise ValueError(f"{text!r} has a zero byte, at which the library would end it; leave it out")
    return found


def name_bytes(text: Any) -> bytes:
    """A name or another text for people: UTF-8, in every locale. Raises ValueError for what is no text, or has no UTF-8."""
    try:
        return text_bytes(text, str.encode)
    except UnicodeEncodeError:
        raise ValueError(f"{text!r} has a character that UTF-8 does not have; a path read as text may have one") from None


def path_or_none(text: Optional[Path]) -> Optional[bytes]:
    return None if text is None else text_bytes(text)


def name_or_none(text: Optional[str]) -> Optional[bytes]:
    return None if text is None else name_bytes(text)


def set_vector(to: Any, field: str, value: Any, name: str, meaning: str) -> None:
    """Sets a field of several numbers. Raises ValueError that names it: "position must be 3 numbers [m], is [1, 2]"."""
    try:
        getattr(to, field)[:] = value
    except (TypeError, ValueError):
        # NumPy's numbers are numbers too, but not always floats.
        try:
            getattr(to, field)[:] = [float(one) for one in value]
        except (TypeError, ValueError):
            raise ValueError(f"{name} must be {len(getattr(to, field))} numbers{meaning}, is {value!r}") from None


def set_number(to: Any, field: str, value: Any, name: str, meaning: str = "") -> None:
    """Sets a field of one number. Raises ValueError that names it."""
    whole = isinstance(getattr(to, field), int)
    try:
        number = int(value) if whole else float(value)
        if whole and not 0 <= number < 1 << 32:
            raise ValueError
        setattr(to, field, number)
    except (TypeError, ValueError, OverflowError):
        raise ValueError(f"{name} must be a {'whole ' if whole else ''}number{meaning}, is {value!r}") from None


def is_vector(struct: Any, field: str) -> bool:
    return isinstance(getattr(struct, field), ctypes.Array)

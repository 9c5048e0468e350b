"""Keywords of Python as options of a program."""
from __future__ import annotations

import os
from typing import Any, Dict, List


def word(value: Any) -> str:
    """A text, a number or a path as a word of a command line. Raises ValueError for None and for bytes, which would stand there as b'...'."""
    if value is None or isinstance(value, (bytes, bytearray, memoryview)):
        raise ValueError(f"{value!r} is no text, number or path; decode bytes, and leave out what is None")
    return os.fsdecode(value) if isinstance(value, os.PathLike) else str(value)


def further(options: Dict[str, Any], *fields: str) -> Dict[str, Any]:
    """The options, none of which is one of `fields`. Raises ValueError that names the field."""
    for name in fields:
        if name in options:
            raise ValueError(f"options has {name!r}, which has a field of its own; set {name}={options[name]!r} there")
    return options


def words(options: Dict[str, Any], *, repeat: bool = False) -> List[str]:
    """{"device": "haply", "rehearsal": False} -> ["--device", "haply", "--no-rehearsal"]

    None is not given. A list is one word with commas; with `repeat` the option is repeated for each, and False is not given, as programs
    without --no- options have it. Raises ValueError for an empty list, and as word()."""
    found: List[str] = []
    for name, value in options.items():
        option = "--" + name.replace("_", "-")
        if isinstance(value, (list, tuple)) and not value:
            raise ValueError(f"{name} is an empty list; leave it out, or give at least one value")
        truth = isinstance(value, bool) or type(value).__name__ in ("bool_", "numpy.bool")  # NumPy's
        if truth and value:
            found.append(option)
        elif truth:
            found += [] if repeat else ["--no-" + option[2:]]
        elif isinstance(value, (list, tuple)) and repeat:
            for one in value:
                found += [option, word(one)]
        elif value is not None:
            found += [option, ",".join(map(word, value)) if isinstance(value, (list, tuple)) else word(value)]
    return found

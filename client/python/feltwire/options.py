"""Keywords of Python as options of a program."""
from __future__ import annotations

import os
from typing import Any, Dict, List


def words(options: Dict[str, Any], *, repeat: bool = False) -> List[str]:
    """{"device": "haply", "local_model": False} -> ["--device", "haply", "--no-local-model"]

    None is not given. A list is one word with commas; with `repeat` the option is repeated for each, and False is not given, as programs
    without --no- options have it. Raises ValueError for an empty list."""
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
                found += [option, str(one)]
        elif value is not None:
            found += [option, ",".join(map(str, value)) if isinstance(value, (list, tuple)) else os.fspath(value)
                      if isinstance(value, os.PathLike) else str(value)]
    return found

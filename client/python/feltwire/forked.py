"""Objects with locks, and child processes."""
from __future__ import annotations

import os
import weakref
from typing import Any

_OBJECTS: "weakref.WeakSet[Any]" = weakref.WeakSet()


def renew_after_fork(one: Any) -> None:
    """Calls one.renew_locks() in every child process: a thread that held a lock in the parent does not exist there. The library refuses
    what the child then asks of its parent's hands."""
    _OBJECTS.add(one)


def _renew() -> None:
    for one in list(_OBJECTS):
        one.renew_locks()


os.register_at_fork(after_in_child=_renew)

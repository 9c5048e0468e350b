"""A hand in a haptic scene, from Python.

    import feltwire

    with feltwire.serve("plane") as server:
        with server.join(device="simulated:path=press", duration=3) as hand:
            hand.wait()
            ticks = hand.ticks()          # every tick since it joined
    print(ticks["force"].max(axis=0))     # [N]

The hand's servo runs in libfeltwire.so, at 1 kHz and more, with the bound, the energy account and the limits of feltwire-client. Python
starts it and reads the latest state; a Python program that pauses makes no tick late. Units are SI. docs/python.md is the
tutorial.

A part of the package is loaded when it is first used: only hands, followers, observers and admins need libfeltwire.so.
"""
import importlib
from typing import TYPE_CHECKING, Any, List

if TYPE_CHECKING:
    from . import aio, gym, isaac, lab, lerobot
    from .admins import Admin, admin
    from .errors import Error, FileError, Refused, SceneError, ServerError
    from .follower import Follower, follow
    from .hand import Hand, join
    from .observer import Observer, observe
    from .plots import plot
    from .recorder import Recorder
    from .recordings import DamageWarning, Recording, read
    from .scenes import Scene
    from .served import Server, play, serve
    from .tables import Table
    from .world import Patch, World

_PLACES = {
    "Admin": "admins", "admin": "admins",
    "Error": "errors", "FileError": "errors", "Refused": "errors", "SceneError": "errors", "ServerError": "errors",
    "Follower": "follower", "follow": "follower",
    "Hand": "hand", "join": "hand",
    "Observer": "observer", "observe": "observer",
    "plot": "plots",
    "Recorder": "recorder",
    "DamageWarning": "recordings", "Recording": "recordings", "read": "recordings",
    "Scene": "scenes",
    "Server": "served", "play": "served", "serve": "served",
    "Table": "tables",
    "Patch": "world", "World": "world",
}

__all__ = ["Admin", "DamageWarning", "Error", "FileError", "Follower", "Hand", "Observer", "Patch", "Recorder", "Recording", "Refused",
           "Scene", "SceneError", "Server", "ServerError", "Table", "World", "admin", "aio", "follow", "gym", "isaac", "join", "lab",
           "lerobot", "observe", "play", "plot", "read", "serve"]


def __getattr__(name: str) -> Any:
    if name in _PLACES:
        return getattr(importlib.import_module(f"{__name__}.{_PLACES[name]}"), name)
    if name == "__version__":
        from .library import BLOCKING
        number = BLOCKING.fw_version()
        return f"{number >> 16}.{number >> 8 & 255}.{number & 255}"
    if name in ("aio", "gym", "isaac", "lab", "lerobot"):
        return importlib.import_module(f"{__name__}.{name}")
    raise AttributeError(f"feltwire has no {name}")


def __dir__() -> List[str]:
    return __all__

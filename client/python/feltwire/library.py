"""Finds libfeltwire.so and the programs."""
import ctypes
import ctypes.util
import os
import pathlib
import shutil
from typing import Any

from . import abi

HERE = pathlib.Path(__file__).resolve().parent
BLOCKING: Any
QUICK: Any


def _path() -> str:
    """FELTWIRE_LIBRARY, a library beside this file (a wheel), or the system's."""
    chosen = os.environ.get("FELTWIRE_LIBRARY")
    if chosen:
        return chosen
    beside = HERE / "libfeltwire.so.0"
    if beside.exists():
        return str(beside)
    return ctypes.util.find_library("feltwire") or "libfeltwire.so.0"


def _load(kind: Any) -> Any:
    path = _path()
    try:
        return abi.declare(kind(path))
    except OSError as error:
        raise ImportError(f"{error}; install libfeltwire0, or set FELTWIRE_LIBRARY to the path of libfeltwire.so.0") from None


def __getattr__(name: str) -> Any:
    """BLOCKING gives other Python threads the interpreter meanwhile. QUICK keeps it: for calls that never wait. The library is loaded when
    the first of them is asked for: without it, the programs are still found."""
    if name not in ("BLOCKING", "QUICK"):
        raise AttributeError(name)
    globals()["BLOCKING"], globals()["QUICK"] = _load(ctypes.CDLL), _load(ctypes.PyDLL)
    return globals()[name]


def program(name: str) -> str:
    """The path of a program of feltwire: beside this file (a wheel), in the folder FELTWIRE_PROGRAMS, or on the PATH."""
    folder = os.environ.get("FELTWIRE_PROGRAMS")
    beside = HERE / "bin" / name
    found = str(beside) if beside.exists() else shutil.which(name, path=folder) if folder else shutil.which(name)
    if found is None:
        raise FileNotFoundError(f"{name} is neither on the PATH nor in the folder FELTWIRE_PROGRAMS; install feltwire-server")
    return found

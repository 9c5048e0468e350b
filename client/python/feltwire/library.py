"""Finds libfeltwire.so, the programs and the scenes. A wheel has them in bin/, lib/ and share/ beside this file."""
import ctypes
import ctypes.util
import os
import pathlib
import shutil
import sys
from typing import Any

from . import abi

HERE = pathlib.Path(__file__).resolve().parent
BLOCKING: Any
QUICK: Any


def _path() -> str:
    """FELTWIRE_LIBRARY, the library of the wheel, or the system's."""
    chosen = os.environ.get("FELTWIRE_LIBRARY")
    if chosen:
        return chosen
    beside = HERE / "lib/libfeltwire.so.0"
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
    """The path of a program of feltwire: in the folder FELTWIRE_PROGRAMS, in the wheel, or on the PATH."""
    beside = HERE / "bin"
    folder = os.environ.get("FELTWIRE_PROGRAMS") or (beside if (beside / name).exists() else None)
    found = shutil.which(name, path=folder)
    if found is None:
        raise FileNotFoundError(f"{name} is neither on the PATH nor in the folder FELTWIRE_PROGRAMS; install feltwire-server")
    return found


def scene_file(scene: "str | os.PathLike[str]") -> str:
    """The path of a scene: a path is taken as it is, and a name, such as "plane", is of a scene that came with the server."""
    if pathlib.Path(scene).is_file() or pathlib.Path(scene).suffix:
        return str(scene)
    folder = pathlib.Path(program("feltwire-server")).resolve().parent.parent / "share/feltwire/scenes"
    found = folder / f"{scene}.json"
    if not found.exists():
        names = ", ".join(sorted(file.stem for file in folder.glob("*.json"))) or "none"
        raise FileNotFoundError(f"there is no scene {scene}; give the path of a file, or one of the names in {folder}: {names}")
    return str(found)


def run_program() -> None:
    """The programs of a wheel, as commands of its environment: runs the one by whose name it was called."""
    path = HERE / "bin" / pathlib.Path(sys.argv[0]).name
    os.execv(path, [str(path), *sys.argv[1:]])

"""Bounding laws of a program, which feltwire-lab judges: feltwire.lab.compare(law), feltwire.lab.extremes(law)."""
from __future__ import annotations

import copy
import re
import socket
import struct
from typing import Any, Callable, Dict, List, NamedTuple, Optional, Sequence, Tuple

from .errors import Error

Vector = Tuple[float, float, float]
Matrix = Tuple[Vector, Vector, Vector]

PROMISES = {"none": 0, "port": 1, "port_by_axis": 2, "own_sum_by_axis": 4, "own_sum": 5}
FAULTS = {"overlong_holds": 1, "reductions": 2, "unknown_inputs": 4}

# The frames of sim/own_laws/socket_law.hpp.
_REQUEST = struct.Struct("<IIQ25d")
_ANSWER = struct.Struct("<II9d")
_DESCRIPTION = struct.Struct("<IIII")
_RESET, _STEP, _HELD = 1, 2, 3


class LawError(Error):
    """A law raised an error, or returned something that is no force. The text names the law, its step and the remedy. __cause__ is the
    error that the law raised."""


class LawFailed(Error):
    """A law broke its promise, or rendered more than the limit. rows: a dict for each stress that shows it, with the columns of
    extremes.csv."""

    def __init__(self, text: str, rows: List[Dict[str, Any]]):
        super().__init__(text)
        self.rows = rows


class Device(NamedTuple):
    """The device and its loop, for which a law is made."""

    period: float
    """T [s] for which a force is held, at least"""
    lag: float
    """[s] by which the motor follows its command, at most"""
    damping: Matrix
    """B [N s/m] of the device, by rows"""
    rotational_damping: Matrix
    """[N m s/rad]"""
    least_damping: float
    """[N s/m] in the direction that is damped least; may be 0"""
    least_rotational_damping: float
    """[N m s/rad]"""
    max_force: float
    """[N] infinite: no limit. What a law returns beyond it is cut"""
    max_torque: float
    """[N m]"""
    rotation: bool
    """False: rotation and torque are zero"""


class Step(NamedTuple):
    """The movement while the last force was held, and the scene's command for the next. World frame; forces are those on the hand."""

    displacement: Vector
    """[m] of the device since the last step"""
    rotation: Vector
    """[rad] rotation vector since the last step"""
    hold_time: float
    """[s] for which the last force was held, at least the period"""
    elastic: Vector
    """[N] commanded by the surfaces"""
    frictional: Vector
    """[N] commanded by all else: friction, damping. The whole command is elastic + frictional"""
    torque: Vector
    """[N m] commanded"""
    local: bool
    """the command was made at the device's position of now"""
    device: Device

    @property
    def force(self) -> Vector:
        """[N] the whole commanded force: elastic + frictional"""
        return (self.elastic[0] + self.frictional[0], self.elastic[1] + self.frictional[1], self.elastic[2] + self.frictional[2])


def _vector(value: Any) -> Vector:
    """Three floats. Raises TypeError or ValueError for anything else."""
    x, y, z = value
    return (float(x), float(y), float(z))


def _force(value: Any) -> Tuple[Vector, Vector, Vector]:
    """What step() returned or set_held() is told, as elastic, frictional and torque. Three numbers are a force without torque."""
    first, second, third = value
    if hasattr(first, "__len__"):
        return _vector(first), _vector(second), _vector(third)
    return (float(first), float(second), float(third)), (0.0, 0.0, 0.0), (0.0, 0.0, 0.0)


def law_name(law: Any) -> str:
    """Its attribute `name`, or that of its class or function: MyLaw is my_law."""
    given = getattr(law, "name", None)
    if given is None:
        plain = getattr(law, "__name__", type(law).__name__)
        given = re.sub(r"(?<=[a-z0-9])(?=[A-Z])", "_", plain).lower()
    if not isinstance(given, str) or not re.fullmatch(r"[a-z0-9_]{1,64}", given):
        raise ValueError(f"the name {given!r} of a law is not 1 to 64 of a to z, 0 to 9 and _; give it an attribute `name`")
    return given


def _described(error: Exception) -> str:
    """Its kind and its words, if it can say them."""
    try:
        return f"{type(error).__name__}: {error}"
    except Exception:  # of its own __str__()
        return type(error).__name__


class _Law:
    """A law of the program, and its entry in the laboratory."""

    def __init__(self, law: Any):
        if not callable(law) and not hasattr(law, "step"):
            raise ValueError(f"{law!r} is no law: give a class or an object with step(), or a function of a step")
        if isinstance(law, type) and not hasattr(law, "step"):
            raise ValueError(f"the class {law.__name__} has no step(); docs/own_bounding_law.md has an example")
        self.law, self.name = law, law_name(law)
        promise, kept = getattr(law, "promise", "port"), getattr(law, "kept_despite", tuple(FAULTS))
        if not isinstance(promise, str) or promise not in PROMISES:
            raise ValueError(f"law {self.name}: its promise {promise!r} is not one of {', '.join(PROMISES)}")
        if not isinstance(kept, (list, tuple, set, frozenset)) or any(not isinstance(fault, str) or fault not in FAULTS for fault in kept):
            raise ValueError(f"law {self.name}: kept_despite is not a list of {', '.join(FAULTS)}")
        name = self.name.encode()
        self.description = _DESCRIPTION.pack(PROMISES[promise], sum(FAULTS[fault] for fault in set(kept)),
                                             bool(getattr(law, "admits_reduction", True)), len(name)) + name

    def run(self, device: Device) -> Any:
        """The law at the beginning of a run: an object of a class is a new one, another object is a copy that was reset."""
        if isinstance(self.law, type):
            return self.law(device)
        if not hasattr(self.law, "step"):
            return _Function(self.law)
        one = copy.deepcopy(self.law)
        if hasattr(one, "reset"):
            one.reset(device)
        return one


class _Function:
    """A law without memory."""

    def __init__(self, function: Callable[[Step], Any]):
        self.step = function


class _Run:
    def __init__(self, law: Any, device: Device):
        self.law, self.device, self.steps = law, device, 0
        self.held: Optional[Callable[[Any], None]] = getattr(law, "set_held", None)


class LawServer:
    """Answers feltwire-lab for the laws of this program. `child` is the socket that the child process inherits."""

    def __init__(self, laws: Sequence[Any]):
        self._laws = [_Law(law) for law in laws]
        names = [law.name for law in self._laws]
        if len(set(names)) < len(names):
            raise ValueError(f"two laws have the same name: {', '.join(names)}; give one an attribute `name`")
        self.names = names
        self._socket, self.child = socket.socketpair()
        self._runs: Dict[int, _Run] = {}
        self.error: Optional[LawError] = None

    @property
    def option(self) -> List[str]:
        return ["--law-socket", f"{self.child.fileno()}:{len(self._laws)}"]

    def close(self) -> None:
        self._socket.close()
        self.child.close()

    def serve(self) -> None:
        """Answers until the child has ended. Call it after the child was started."""
        self.child.close()
        request = bytearray(_REQUEST.size)
        view = memoryview(request)
        receive, send, unpack = self._socket.recv_into, self._socket.sendall, _REQUEST.unpack_from
        try:
            send(b"".join(law.description for law in self._laws))
            while True:
                size = receive(view)
                while 0 < size < _REQUEST.size and (more := receive(view[size:])):
                    size += more
                if size < _REQUEST.size:
                    return
                kind, law, run, *numbers = unpack(request)
                answer = self._answer(kind, law, run, numbers)
                if answer is not None:
                    send(answer)
        except (BrokenPipeError, ConnectionResetError):
            return  # its exit status and its words say why

    def _answer(self, kind: int, law: int, number: int, numbers: List[float]) -> Optional[bytes]:
        if self.error is not None:  # of this step, or of set_held() before it
            return None if kind == _HELD else self._refusal(self.error)
        try:
            if kind == _STEP:
                run = self._runs[number]
                run.steps += 1
                n = numbers
                step = Step((n[0], n[1], n[2]), (n[3], n[4], n[5]), n[6], (n[7], n[8], n[9]), (n[10], n[11], n[12]),
                            (n[13], n[14], n[15]), n[16] != 0.0, run.device)
                given = run.law.step(step)
                try:
                    elastic, frictional, torque = _force(given)
                except (TypeError, ValueError):
                    raise LawError(f"step() returned {given!r}; return the force as 3 numbers [N], or elastic, frictional and torque as "
                                   "3 numbers each") from None
                return _ANSWER.pack(0, 0, *elastic, *frictional, *torque)
            if kind == _RESET:
                rows = [(numbers[i], numbers[i + 1], numbers[i + 2]) for i in range(2, 20, 3)]
                device = Device(numbers[0], numbers[1], (rows[0], rows[1], rows[2]), (rows[3], rows[4], rows[5]), *numbers[20:24],
                                numbers[24] != 0.0)
                self._runs[number] = _Run(self._laws[law].run(device), device)
                return _ANSWER.pack(0, 0, *[0.0] * 9)
            held = self._runs[number].held
            if held is not None:
                held((tuple(numbers[0:3]), tuple(numbers[3:6]), tuple(numbers[6:9])))
            return None
        except Exception as error:  # whatever the law raises
            self._fail(law, number, error)
            return None if kind == _HELD else self._refusal(self.error)

    def _fail(self, law: int, number: int, error: Exception) -> None:
        at = self._runs[number].steps if number in self._runs else 0
        what = str(error) if isinstance(error, LawError) else f"it raised {_described(error)}; __cause__ is the error itself"
        self.error = LawError(f"law {self._laws[law].name}: step {at}: {what}")
        if not isinstance(error, LawError):
            self.error.__cause__ = error

    @staticmethod
    def _refusal(error: Optional[LawError]) -> bytes:
        text = str(error).encode(errors="replace")[:4096]
        return _ANSWER.pack(1, len(text), *[0.0] * 9) + text

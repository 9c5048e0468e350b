"""A hand in the world of a simulator: MuJoCo, PyBullet, Isaac, or physics of your own."""
from __future__ import annotations

import ctypes
from typing import Any, Callable, Iterable, Iterator, NamedTuple, Optional, Sequence, Tuple

from . import abi
from .hand import Hand, _raise, set_hand
from .library import BLOCKING, QUICK
from .pacing import paced
from .values import is_vector, set_number, set_vector

Vector = Sequence[float]
_NONE = (0.0, 0.0, 0.0)
_PATCH_SIZE = ctypes.sizeof(abi.Patch)


class Patch(NamedTuple):
    """A surface near the tool, described around its point nearest to the tool. World frame."""

    point: Vector
    """[m] on the surface"""
    normal: Vector
    """unit, towards the free side"""
    stiffness: float
    """[N/m] above 0"""
    curvature: float = 0.0
    """[1/m] 1/radius of a ball felt from outside, below 0 from inside, 0: a plane"""
    axis: Vector = _NONE
    """unit vector along which the surface is straight (a cylinder); zero: the same curve all ways"""
    velocity: Vector = _NONE
    """[m/s] of the surface"""
    radius: float = 0.0
    """[m] within which the patch is right, from its point; 0: the reach"""
    damping: float = 0.0
    """[N s/m] along the normal"""
    static_friction: float = 0.0
    """coefficient, not below dynamic_friction"""
    dynamic_friction: float = 0.0
    """coefficient"""
    viscous_friction: float = 0.0
    """[N s/m] against sliding"""
    object: int = 0
    """a number of your own: friction sticks to an object from one call to the next"""


class World(Hand):
    """A hand whose surroundings your program computes, at 60 to 1000 Hz. The hand feels them at its servo rate, behind the same bound,
    energy account and limits as in a scene of a server. If your program pauses, the force fades within the hold time (0.1 s).

    device, spec, name, duration, stale_after and all other keywords: as in feltwire.join(). stiffness [N/m]: of the stiffest surface
    that the hand will meet, by which the hand's bounding is set. start [m], normal: a point on a surface and the unit normal there, where a simulated hand begins.

    Raises ValueError for a wrong option, or Error. Use it in a `with` block, or call close().
    """

    def __init__(self, *, stiffness: float, start: Vector = _NONE, normal: Vector = (0.0, 0.0, 1.0), device: str = "simulated",
                 spec: Optional[str] = None, name: str = "python", duration: float = 0.0, stale_after: float = 0.02, **options: Any):
        given = abi.WorldOptions()
        BLOCKING.fw_world_options_default(given, ctypes.sizeof(given))
        set_number(given, "stiffness", stiffness, "stiffness", " [N/m]")
        set_vector(given, "start_position", start, "start", " [m]")
        set_vector(given, "start_normal", normal, "normal", "")
        set_hand(given, device, spec, name, duration, stale_after, options)
        handle = ctypes.c_void_p()
        if (result := BLOCKING.fw_hand_open_world(given, handle)) < 0:
            _raise(result)
        super().__init__(handle)
        self._patches = (abi.Patch * 3)()
        self._wrench = abi.Wrench()
        BLOCKING.fw_wrench_default(self._wrench, ctypes.sizeof(self._wrench))
        for patch in self._patches:
            BLOCKING.fw_patch_default(patch, ctypes.sizeof(patch))

    def touch(self, patches: Iterable[Patch], reach: float, time: Optional[float] = None) -> bool:
        """Says which surfaces are within `reach` [m] of the tool: at most three patches; none: nothing is there.

        time [s]: that of the tick whose position your physics used; None: the newest one. Returns False if the hand does not take them:
        there was no tick yet, `time` is older than the hold time or than that of the last call, or the servo stands still. Raises ValueError
        for a patch that is not possible.
        """
        if patches is None:
            raise ValueError("the physics returned None; return a list of patches, [] where nothing is near")
        given = [patches] if isinstance(patches, Patch) else list(patches)
        if len(given) > len(self._patches):
            raise ValueError(f"{len(given)} patches: at most 3 can be given. Give the nearest, and a shorter reach")
        for number, (to, patch) in enumerate(zip(self._patches, given)):
            if not isinstance(patch, Patch):
                raise ValueError(f"patches[{number}] must be a feltwire.Patch, is {patch!r}")
            for field, value in zip(Patch._fields, patch):
                (set_vector if is_vector(to, field) else set_number)(to, field, value, f"patches[{number}].{field}", "")
        try:
            reach = float(reach)
        except (TypeError, ValueError):
            raise ValueError(f"reach must be a number [m], is {reach!r}") from None
        seen, count = self._time(time), len(given)
        # Nothing of Python runs between the look at the handle and the call: another thread may close the hand.
        return self._given(QUICK.fw_hand_touch(self._open(), seen, reach, self._patches, _PATCH_SIZE, count))

    def push(self, force: Vector, stiffness: float = 0.0, *, torque: Vector = _NONE, time: Optional[float] = None) -> bool:
        """Says the force [N] and the torque [N m] of the surroundings on the hand. With a stiffness [N/m] the hand feels the plane that
        has this force at the position of that time; without one the force as it is, as far as the account pays for it. Prefer touch(): a
        patch is felt before it pushes.

        time and the result: as for touch().
        """
        wrench = self._wrench
        set_vector(wrench, "force", force, "force", " [N]")
        set_vector(wrench, "torque", torque, "torque", " [N m]")
        set_number(wrench, "stiffness", stiffness, "stiffness", " [N/m]")
        set_number(wrench, "time", self._time(time), "time", " [s]")
        return self._given(QUICK.fw_hand_push(self._open(), wrench))

    @staticmethod
    def _given(result: int) -> bool:
        if result < 0:
            _raise(result)
        return result == abi.OK

    def why_no_force(self) -> str:
        """As Hand.why_no_force(). Physics that takes longer than half the hold time has to give a longer one, as hold_time=0.3."""
        said = super().why_no_force()
        if "answer" not in said:
            return said
        hold = self.session.hold_time
        return f"the physics gave nothing for {0.5 * hold:.3g} s or longer: give results more often, or a longer hold_time (it is {hold:.3g} s)"

    def _time(self, time: Optional[float]) -> float:
        if time is not None:
            return time
        newest = self._newest(self._asked)
        return newest.time if newest is not None else 0.0

    def paced(self, rate: float, duration: Optional[float] = None) -> Iterator[float]:
        """Yields the time [s] since the call, `rate` times a second from the first tick on, until the run has ended or for `duration` [s].
        Work that takes longer than a period delays the next one; none is made up for."""
        while self.latest() is None:
            if self.wait(0.001):
                return
        yield from paced(rate, duration, self.wait)

    def run(self, physics: Callable[[Tuple[float, ...], float], Iterable[Patch]], *, reach: float, rate: float = 100.0,
            duration: Optional[float] = None) -> None:
        """Calls physics(position [m], time [s]) as paced() does, and gives its patches to the hand, which are all surfaces within
        `reach` [m]."""
        for _ in self.paced(rate, duration):
            tick = self.latest()
            if tick is not None:
                time = tick.time
                self.touch(physics(tuple(tick.position), time), reach, time)

"""Gymnasium: a hand feels the contacts of an environment. feltwire.gym.FeltEnv(env, contacts, stiffness=...) is a gymnasium.Wrapper.

Importing this module imports nothing else; the class is made when it is first asked for, and then Gymnasium must be installed.
"""
from __future__ import annotations

from typing import TYPE_CHECKING, Any, Callable, Dict, NamedTuple, Optional, Sequence, Tuple

from .errors import Error

if TYPE_CHECKING:
    FeltEnv: Any


class Wrench(NamedTuple):
    """What an environment knows that has no surfaces: its force on the hand."""

    force: Sequence[float]
    """[N] on the hand, world frame"""
    stiffness: float = 0.0
    """[N/m] with which the force changes with the position along the force; 0: not known, and the account gives less of it"""
    torque: Sequence[float] = (0.0, 0.0, 0.0)
    """[N m] on the hand"""


def _felt_env() -> Any:
    try:
        import gymnasium
    except ImportError:
        raise Error("feltwire.gym.FeltEnv needs the Python package gymnasium; install it") from None
    from .world import World

    class FeltEnv(gymnasium.Wrapper):  # type: ignore[misc, name-defined]
        """An environment whose contacts a hand feels at its servo rate, however slow step() is.

        contacts(env, position): called after each step with the unwrapped environment and the position [m] of the hand before the step.
        Returns the surfaces near it, a list of feltwire.Patch ([]: nothing is near), or a Wrench. reach [m]: within which the list has all
        surfaces. stiffness [N/m]: of the stiffest surface. act(action, tick): the action for the environment, from that of the caller and
        the newest tick of the hand (None before the first); without it the caller's action. All other keywords are those of
        feltwire.World: device, start, normal, hold_time, max_force.

        step() and reset() add info["feltwire"]: position [m], orientation (w, x, y, z), force [N] and torque [N m] on the hand,
        scene_force [N] before the bound, taken: whether the hand took what contacts() said, and ended. reset() takes the surfaces away. If step()
        is not called for half the hold time, the force fades. close() ends the hand's run.

        A run that ends by itself (duration, the device, an error) truncates the episode: the step that finds it returns truncated=True, and
        info["feltwire"]["ended"] is True. After it step() and reset() raise Error, since nobody feels the environment.
        """

        def __init__(self, env: Any, contacts: Callable[[Any, Tuple[float, ...]], Any], *, stiffness: float, reach: float = 0.02,
                     act: Optional[Callable[[Any, Any], Any]] = None, **options: Any):
            super().__init__(env)
            self.contacts, self.reach, self.act = contacts, reach, act
            self.hand = World(stiffness=stiffness, **options)
            self._ended = False  # and the program was told

        def step(self, action: Any) -> Any:
            self._require_hand()
            tick = self.hand.latest()
            before = None if tick is None else (tuple(tick.position), tick.time)
            if self.act is not None:
                action = self.act(action, tick)
            observation, reward, terminated, truncated, info = self.env.step(action)
            taken = before is not None and self._publish(*before)
            self._ended = self.hand.wait(0.0)
            return observation, reward, terminated, truncated or self._ended, {**info, "feltwire": self._felt(taken)}

        def reset(self, *, seed: Optional[int] = None, options: Optional[Dict[str, Any]] = None) -> Any:
            self._require_hand()
            observation, info = self.env.reset(seed=seed, options=options)
            taken = self.hand.touch([], self.reach) if self.hand.latest() is not None else False
            return observation, {**info, "feltwire": self._felt(taken)}

        def _require_hand(self) -> None:
            if self._ended:
                raise Error("the hand's run has ended; close() tells why, and another FeltEnv has another hand")

        def close(self) -> Any:
            self.hand.close()
            return self.env.close()

        def _publish(self, position: Tuple[float, ...], time: float) -> bool:
            found = self.contacts(self.env.unwrapped, position)
            if isinstance(found, Wrench):
                return self.hand.push(found.force, found.stiffness, torque=found.torque, time=time)
            return self.hand.touch(found, self.reach, time)

        def _felt(self, taken: bool) -> Dict[str, Any]:
            tick, said = self.hand.latest(), {"taken": taken, "ended": self._ended}
            return said if tick is None else {**said, **{name: tuple(getattr(tick, name)) for name in ("position", "orientation", "force", "torque", "scene_force")}}

    return FeltEnv


def __getattr__(name: str) -> Any:
    if name != "FeltEnv":
        raise AttributeError(f"feltwire.gym has no {name}")
    globals()[name] = _felt_env()
    return globals()[name]


def __dir__() -> Any:
    return ["FeltEnv", "Wrench"]

"""Isaac Lab: feltwire.isaac.FeltDevice is an isaaclab.devices.DeviceBase, a hand that feels the forces of the simulation.

Importing this module imports nothing else; the class is made when it is first asked for, and then Isaac Lab must be installed.
"""
from __future__ import annotations

from dataclasses import dataclass, field
from typing import TYPE_CHECKING, Any, Callable, Dict, List, Optional, Sequence

from .errors import Error
from .options import further

if TYPE_CHECKING:
    FeltDevice: Any


@dataclass
class FeltDeviceCfg:
    """How the hand is made. Isaac Lab's own fields are sim_device and retargeters."""

    stiffness: float = 1000.0
    """[N/m] of the stiffest contact that the hand will meet"""
    device: str = "simulated"
    """as --device of feltwire-client"""
    options: Dict[str, Any] = field(default_factory=dict)
    """further keywords of feltwire.World: path, max_force, hold_time"""
    sim_device: str = "cpu"
    """of the tensors that advance() returns"""
    retargeters: Sequence[Any] = ()


def _selected(rows: List[Any], position: Any) -> List[Any]:
    """The rows that rows[position] of a tensor selects."""
    chosen = position.reshape(-1).tolist() if hasattr(position, "reshape") else list(position) if hasattr(position, "__iter__") else [position]
    if chosen and all(isinstance(one, bool) for one in chosen):
        if len(chosen) != len(rows):
            raise ValueError(f"position is a mask of {len(chosen)} truth values for {len(rows)} forces; give one for each force")
        return [row for row, counts in zip(rows, chosen) if counts]
    for one in chosen:
        if isinstance(one, bool) or not isinstance(one, int) or not -len(rows) <= one < len(rows):
            raise ValueError(f"position has {one!r}; give whole numbers below {len(rows)}, the number of forces, or a mask of truth values")
    return [rows[one] for one in chosen]


def _felt_device() -> Any:
    try:
        import torch
        from isaaclab.devices import DeviceBase
    except ImportError as error:
        raise Error(f"feltwire.isaac.FeltDevice needs Isaac Lab ({error}); run it in Isaac Lab's Python") from None
    from .world import World

    class FeltDevice(DeviceBase):  # type: ignore[misc]
        """A device for Isaac Lab whose force feedback is rendered by feltwire's servo, behind its bound, account and limits.

        advance() returns the pose of the hand [x, y, z, qx, qy, qz, qw], m and a unit quaternion, or what the retargeters make of it.
        push_force() gives the force of the simulation. It is felt as a plane of cfg.stiffness through the pose of the last advance(). If
        it is not called for half the hold time (0.1 s), the force fades to zero by itself.

        Callbacks: "START" with the first pose, "STOP" when the run has ended (by itself, the device or an error). Other keys are kept and
        never called: the hand has no keyboard.
        """

        def __init__(self, cfg: FeltDeviceCfg, retargeters: Optional[Sequence[Any]] = None):
            super().__init__(list(retargeters) if retargeters is not None else list(cfg.retargeters))
            self.cfg = cfg
            self.hand = World(stiffness=cfg.stiffness, device=cfg.device, **further(cfg.options, "stiffness", "device"))
            self._callbacks: Dict[Any, Callable[[], Any]] = {}
            self._time: Optional[float] = None  # [s] of the pose that the simulation has
            self._ended = False

        def __str__(self) -> str:
            return f"feltwire hand ({self.cfg.device}): x, y, z [m], qx, qy, qz, qw; push_force() is felt, START and STOP are called"

        def reset(self) -> None:
            """Takes the force off, until the next push_force()."""
            if self._time is not None and not self._ended:
                self.hand.push((0.0, 0.0, 0.0))

        def add_callback(self, key: Any, func: Callable[[], Any]) -> None:
            """func is called without arguments."""
            self._callbacks[key] = func

        def _get_raw_data(self) -> Any:
            tick = self.hand.latest()
            if tick is None:
                start = self.hand.session.start_position
                return torch.tensor([*start, 0.0, 0.0, 0.0, 1.0], dtype=torch.float32, device=self.cfg.sim_device)
            if self._time is None:
                self._call("START")
            self._time = tick.time
            w, x, y, z = tick.orientation
            return torch.tensor([*tick.position, x, y, z, w], dtype=torch.float32, device=self.cfg.sim_device)

        def advance(self) -> Any:
            raw = self._get_raw_data()
            if not self._ended and self.hand.wait(0.0):
                self._ended = True
                self._call("STOP")
            if not self._retargeters:
                return raw
            return torch.cat([retargeter.retarget(raw) for retargeter in self._retargeters], dim=-1)

        def push_force(self, forces: Any, position: Any = None) -> bool:
            """forces: a tensor (N, 3) [N] on the hand, world frame. position: which of them count, and are added up, as forces[position]
            selects them: a number, whole numbers, or a mask of N truth values; None: all. Where it selects none, the force is zero. Raises
            ValueError for a position that selects nothing that is there. Returns whether the hand took it: not before the first advance() with a pose, and not after the run's end."""
            rows = forces.detach().cpu().reshape(-1, 3).tolist()
            if not rows:
                raise ValueError("push_force() got no forces; give a tensor (N, 3)")
            if position is not None:
                rows = _selected(rows, position)
            if self._time is None or self._ended:
                return False
            force = [sum(row[axis] for row in rows) for axis in range(3)]
            return self.hand.push(force, self.cfg.stiffness, time=self._time)

        def close(self) -> None:
            """Ends the hand's run."""
            self.hand.close()

        def _call(self, key: str) -> None:
            if key in self._callbacks:
                self._callbacks[key]()

    return FeltDevice


def __getattr__(name: str) -> Any:
    if name != "FeltDevice":
        raise AttributeError(f"feltwire.isaac has no {name}")
    globals()[name] = _felt_device()
    return globals()[name]


def __dir__() -> Any:
    return ["FeltDevice", "FeltDeviceCfg"]

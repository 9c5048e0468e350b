"""A robot that follows a hand."""
from __future__ import annotations

import ctypes
from typing import Any, Iterator, List, Optional, Sequence, Tuple

from . import abi
from .access import set_access
from .handle import Handle, _raise, messages_of
from .library import BLOCKING, QUICK
from .pacing import paced
from .values import Path, name_or_none, set_number, set_vector

Vector = Sequence[float]

_TARGET_SIZE = ctypes.sizeof(abi.RobotTarget)
_AXES = ("x", "y", "z", "rotation")
_STEP = 0.1  # [s] Python looks for Ctrl-C between two calls
_NONE = (0.0, 0.0, 0.0)
_STOPPED, _FAULT = 1, 2


def follow(server: str, scene: str, *, stiffness: float, seat: Optional[str] = None, robot: str = "robot", name: str = "python",
           period: float = 0.001, damping: float = 0.0, own_damping: float = 0.0, mass: float = 0.0, wrench_noise: float = 0.0,
           estimates_force: bool = False, gripper_opening: float = 0.0, speed: Optional[float] = None,
           acceleration: Optional[float] = None, jerk: Optional[float] = None, leash: Optional[float] = None,
           workspace: Optional[Tuple[Vector, Vector]] = None, locked: Sequence[str] = (), duration: float = 0.0, patience: float = 30.0,
           token_file: Optional[Path] = None, fingerprint: Optional[str] = None, fingerprint_file: Optional[Path] = None,
           ca_file: Optional[Path] = None, certificate_file: Optional[Path] = None, key_file: Optional[Path] = None) -> Follower:
    """Takes a seat for a robot in a scene, and returns its Follower. Blocks until the server has answered.

    server: "HOST:PORT". scene: its name. seat: the name of the seat; None: the only one of the scene. Credentials as in feltwire.join(), with
    a token of the role follower.

    The robot has an impedance controller of its own: stiffness [N/m] and damping [N s/m] are the controller's, own_damping [N s/m] is what its
    body has for certain, mass [kg] is what shows at the tool (0: not known). wrench_noise [N]: the largest error of a measured force;
    estimates_force: the force is no measurement. gripper_opening [m]: the largest; 0: there is no gripper. period [s]: of the library's loop,
    0.0001 to 0.05; your own loop may have another rate.

    speed [m/s], acceleration [m/s^2], jerk [m/s^3] limit the target, and leash [N] the force by which it pulls the robot. workspace [m]: two
    corners of a box for the target, beside the workspace of the seat. locked: some of "x", "y", "z", "rotation", which stay while a
    hand is engaged. duration [s]: when the run ends; 0: at close(). patience [s]: for which a lost session is looked for.

    Raises ValueError for a wrong option, Refused, ServerError, or Error.
    """
    given = abi.FollowerOptions()
    BLOCKING.fw_follower_options_default(given, ctypes.sizeof(given))
    set_access(given, server, token_file, fingerprint, fingerprint_file, ca_file, certificate_file, key_file)
    given.scene, given.seat, given.robot, given.name = name_or_none(scene), name_or_none(seat), name_or_none(robot), name_or_none(name)
    numbers = {"stiffness": stiffness, "period": period, "damping": damping, "own_damping": own_damping, "mass": mass,
               "wrench_noise": wrench_noise, "gripper_opening": gripper_opening, "speed": speed, "acceleration": acceleration, "jerk": jerk,
               "leash": leash, "duration": duration, "patience": patience}
    for field, value in numbers.items():
        if value is not None:
            set_number(given, field, value, field)
    given.estimates_force = bool(estimates_force)
    if workspace is not None:
        if not hasattr(workspace, "__len__") or len(workspace) != 2:
            raise ValueError(f"workspace must be two corners of a box [m], is {workspace!r}")
        set_vector(given, "workspace_low", workspace[0], "workspace[0]", " [m]")
        set_vector(given, "workspace_high", workspace[1], "workspace[1]", " [m]")
    if not isinstance(locked, (list, tuple, set, frozenset)):
        raise ValueError(f"locked must be a list of {', '.join(_AXES)}, is {locked!r}")
    for axis in locked:
        if axis not in _AXES:
            raise ValueError(f"locked has {axis!r}; give some of {', '.join(_AXES)}")
        given.locked |= 1 << _AXES.index(axis)
    handle = ctypes.c_void_p()
    result = BLOCKING.fw_follower_open(given, handle)
    if result != abi.OK:
        _raise(result)
    return Follower(handle)


class Follower(Handle):
    """A robot that follows a hand. Use it in a `with` block, or call close(). In a loop of 100 to 1000 Hz:

        for _ in follower.paced(500):
            target = follower.exchange(robot.position, force=robot.force)
            if target is None:
                break
            robot.go_to(target.position)  # its own impedance controller
    """

    NAME = "follower"
    AIO = "use feltwire.aio.follow(server.address, scene, ...)"

    def __init__(self, handle: ctypes.c_void_p):
        super().__init__(handle)
        self._target, self._watched, self._asked = abi.RobotTarget(), abi.RobotTarget(), abi.RobotTarget()
        self._state = abi.RobotState()
        BLOCKING.fw_robot_state_default(self._state, ctypes.sizeof(self._state))
        self._has_target = False

    def exchange(self, position: Vector, orientation: Vector = (1.0, 0.0, 0.0, 0.0), *, velocity: Vector = _NONE, turning: Vector = _NONE,
                 force: Optional[Vector] = None, torque: Vector = _NONE, commanded: Optional[Vector] = None,
                 commanded_orientation: Optional[Vector] = None, gripper: float = 0.0, gripper_force: float = 0.0, stopped: bool = False,
                 fault: bool = False) -> Optional[abi.RobotTarget]:
        """Gives what the robot measures, and returns the newest target for its controller; None: the run has ended, and the robot stays.

        In the robot's own world frame: position [m] and orientation of the tool (unit quaternion w, x, y, z), velocity [m/s], turning [rad/s],
        force [N] and torque [N m] of the environment on the tool. force=None: it is not known, which is not zero. commanded [m] and
        commanded_orientation: the target that the controller holds now; None: the one that was returned last, at first the robot's own place.
        gripper [m]: its opening; gripper_force [N]: that it holds with. stopped: a protective stop, or its people hold it. fault: it has a
        fault. A robot that is stopped or has a fault, or of which nothing was heard for 0.1 s, is not led.

        The target has position [m], orientation, gripper [m], state, age [s] of the newest command (-1: there is none), connected. The next
        call overwrites it. Before the first target of the library it is where the controller is already. Raises ValueError for a state that no
        robot can be in. Never waits.
        """
        state, target = self._state, self._target
        set_vector(state, "position", position, "position", " [m]")
        set_vector(state, "orientation", orientation, "orientation", " w, x, y, z")
        set_vector(state, "velocity", velocity, "velocity", " [m/s]")
        set_vector(state, "turning", turning, "turning", " [rad/s]")
        state.has_force = force is not None
        set_vector(state, "force", _NONE if force is None else force, "force", " [N]")
        set_vector(state, "torque", torque, "torque", " [N m]")
        held = (target.position, target.orientation) if self._has_target else (position, orientation)
        set_vector(state, "commanded_position", held[0] if commanded is None else commanded, "commanded", " [m]")
        set_vector(state, "commanded_orientation", held[1] if commanded_orientation is None else commanded_orientation,
                   "commanded_orientation", " w, x, y, z")
        set_number(state, "gripper", gripper, "gripper", " [m]")
        set_number(state, "gripper_force", gripper_force, "gripper_force", " [N]")
        state.condition = _FAULT if fault else _STOPPED if stopped else 0
        result = QUICK.fw_follower_exchange(self._open(), state, target, _TARGET_SIZE)
        if result < 0:
            _raise(result)
        if result == abi.NOTHING:
            target.position[:], target.orientation[:] = state.commanded_position, state.commanded_orientation
            target.gripper, target.age = state.gripper, -1.0
        self._has_target = True
        return None if result == abi.ENDED else target

    def latest(self) -> Optional[abi.RobotTarget]:
        """The newest target of the library, to watch the robot, or None before the first. The next call overwrites it. Never waits."""
        return self._newest(self._watched)

    def _newest(self, target: abi.RobotTarget) -> Optional[abi.RobotTarget]:
        result = QUICK.fw_follower_latest(self._open(), target, _TARGET_SIZE)
        if result < 0:
            _raise(result)
        return target if result == abi.OK else None

    @property
    def state(self) -> str:
        """Between hand and robot, in the newest command: "disabled" (a hand is missing), "ready", "engaged" (the target follows the hand),
        "clutched", "hold", "fault" or "aligning"."""
        target = self._newest(self._asked)
        return str(QUICK.fw_lead_state_text(0 if target is None else target.state), "utf-8")

    def paced(self, rate: float, duration: Optional[float] = None) -> Iterator[float]:
        """Yields the time [s] since the call, `rate` times a second, until the run has ended or for `duration` [s]. Work that takes longer than
        a period delays the next one; none is made up for."""
        return paced(rate, duration, self.wait)

    def messages(self) -> List[str]:
        """What happened to the session since the last call: the seat was lost, or the robot has it again."""
        return messages_of(self, BLOCKING.fw_follower_message)

    def wait(self, timeout: float = 1e6) -> bool:
        """Waits until the run has ended, at most `timeout` [s]; 0: only asks. Returns whether it has. Ctrl-C interrupts it."""
        while True:
            with self._lock:
                result = BLOCKING.fw_follower_wait(self._open(), max(min(_STEP, timeout), 0.0))
            if result < 0:
                _raise(result)
            if result == abi.ENDED:
                return True
            timeout -= _STEP
            if timeout <= 0.0:
                return False

    def stop(self) -> None:
        """Leaves the scene. The target brakes for 0.25 s, then exchange() returns None. Does not wait."""
        # QUICK, and without the lock, which a thread in wait() has for 0.1 s.
        result = QUICK.fw_follower_stop(self._open())
        if result < 0:
            _raise(result)

    def close(self) -> None:
        """Leaves the scene; the robot stays at its last target. Raises Error if an error had ended the run. May be called again."""
        super().close()

"""LeRobot: the methods of a teleoperator that is a hand of feltwire. The plug-in lerobot_teleoperator_feltwire makes it a Teleoperator of
LeRobot, which finds it by the name of its package: --teleop.type=feltwire.

Importing this module imports nothing else.
"""
from __future__ import annotations

import math
from typing import Any, Dict, Optional

from .options import further

_POSE = ("x", "y", "z", "qw", "qx", "qy", "qz")
_FELT = tuple(f"{what}_{axis}" for what in ("force", "torque", "scene_force") for axis in "xyz") + ("reduced", "account_cut", "no_force")
_FEEDBACK = tuple(f"{what}_{axis}" for what in ("force", "torque") for axis in "xyz") + ("stiffness",)
_SMALLEST = 0.005  # [N] below it nothing is felt (ZeroForceReason)
_MUCH_LESS = 0.95


class HandTeleoperator:
    """What LeRobot's Teleoperator asks for, with a hand of feltwire behind it. Its config has the fields of FeltwireTeleoperatorConfig.

    With a server the hand feels a scene of that server at its servo rate, whether or not send_feedback() is ever called: the robot's
    surroundings are there, or the robot itself (docs/teleoperation.md). Without a server it feels what send_feedback() says, behind the same
    bound; a feedback that stops fades within the hold time.
    """

    config: Any
    _hand: Any = None
    _time: Optional[float] = None  # [s] of the pose that the robot was given last

    @property
    def action_features(self) -> Dict[str, type]:
        """The pose of the hand, x, y, z [m] and the unit quaternion qw to qz. With config.record_feel also force and torque as felt [N, N m],
        scene_force [N] as the surroundings commanded it, reduced (1: bound, account or limits gave less of it), account_cut (share that the
        account took off) and no_force (number of the reason for no force, 0: felt or nothing is touched)."""
        return dict.fromkeys(_POSE + (_FELT if self.config.record_feel else ()), float)

    @property
    def feedback_features(self) -> Dict[str, type]:
        """Without a server: force [N] and torque [N m] on the hand, and stiffness [N/m] of the contact. With one: nothing."""
        return {} if self.config.server else dict.fromkeys(_FEEDBACK, float)

    @property
    def is_connected(self) -> bool:
        return self._hand is not None

    def connect(self, calibrate: bool = True) -> None:
        """Joins the scene, or makes a hand with physics of its own. Raises Refused, ServerError, Error or ValueError."""
        if self._hand is not None:
            raise self._already_connected(f"{self} is already connected")
        config = self.config
        fields = ("server", "scene", "fingerprint_file", "token_file", "device", "stiffness")
        options: Dict[str, Any] = {"device": config.device, **further(config.options, *fields)}
        if config.server:
            from .hand import join
            self._hand = join(config.server, config.scene, fingerprint_file=config.fingerprint_file, token_file=config.token_file, **options)
        else:
            from .world import World
            self._hand = World(stiffness=config.stiffness, **options)
        self._time = None
        if calibrate and not self.is_calibrated:
            self.calibrate()
        self.configure()

    @property
    def is_calibrated(self) -> bool:
        return True  # the servo waits until the device has found its zero, and gives no force before

    def calibrate(self) -> None:
        pass

    def configure(self) -> None:
        pass

    def get_action(self) -> Dict[str, float]:
        """The newest tick; before the first the start of the scene with the first orientation. Raises Error when the run has ended."""
        hand = self._connected()
        ended, tick = hand.wait(0.0), hand.latest()
        if ended:
            self._hand = None
            hand.close()  # raises the error that ended it
            from .errors import Error
            raise Error("the hand's run has ended; connect() joins again")
        if tick is None:
            found = dict(zip(_POSE, (*hand.session.start_position, 1.0, 0.0, 0.0, 0.0)))
            return {**found, **(dict.fromkeys(_FELT, 0.0) if self.config.record_feel else {})}
        self._time = tick.time
        found = dict(zip(_POSE, (*tick.position, *tick.orientation)))
        if self.config.record_feel:
            commanded, felt = _length(tick.scene_force), _length(tick.force)
            reduced = commanded > _SMALLEST and felt < _MUCH_LESS * commanded
            found.update(zip(_FELT, (*tick.force, *tick.torque, *tick.scene_force, float(reduced), tick.account_cut,
                                     float(tick.zero_force_reason))))
        return found

    def send_feedback(self, feedback: Dict[str, Any]) -> None:
        """Without a server: the wrench on the hand of the robot's contact at the pose of the last get_action(). What is missing is zero, but
        for the stiffness, which is config.stiffness. Names that feedback_features does not have are ignored: LeRobot gives the whole
        observation of a robot. With a server: ignored. Raises ValueError that names what is no finite number, and gives the hand nothing."""
        hand = self._connected()
        if self.config.server or not any(name in feedback for name in _FEEDBACK[:-1]):
            return
        part = {name: _number(feedback, name) for name in _FEEDBACK}
        if self._time is None:
            return
        hand.push([part[f"force_{axis}"] for axis in "xyz"], part["stiffness"] if "stiffness" in feedback else self.config.stiffness,
                  torque=[part[f"torque_{axis}"] for axis in "xyz"], time=self._time)

    def disconnect(self) -> None:
        """Lets the force fade and ends the run."""
        hand = self._connected()
        self._hand = None
        hand.close()

    def _connected(self) -> Any:
        if self._hand is None:
            raise self._not_connected(f"{self} is not connected; call connect()")
        return self._hand

    # LeRobot's own errors, where it is installed.
    _already_connected: Any = ConnectionError
    _not_connected: Any = ConnectionError


def _number(feedback: Dict[str, Any], name: str) -> float:
    value = feedback.get(name, 0.0)
    try:
        number = float(value)
    except (TypeError, ValueError):
        number = math.nan
    if not math.isfinite(number):
        unit = {"force": "N", "torque": "N m", "stiffness": "N/m"}[name.split("_", maxsplit=1)[0]]
        raise ValueError(f"feedback[{name!r}] must be a finite number [{unit}], is {value!r}; leave out what is not known")
    return number


def _length(vector: Any) -> float:
    return float(sum(one * one for one in vector)) ** 0.5


def hand_of(teleoperator: HandTeleoperator) -> Optional[Any]:
    """The Hand or World behind a teleoperator that is connected, for all that LeRobot has no word for; else None."""
    return teleoperator._hand

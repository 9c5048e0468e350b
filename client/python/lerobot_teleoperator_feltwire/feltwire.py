"""The teleoperator: the methods of feltwire.lerobot under LeRobot's base class."""
from feltwire.lerobot import HandTeleoperator
from lerobot.teleoperators.teleoperator import Teleoperator

from .config_feltwire import FeltwireTeleoperatorConfig

try:
    from lerobot.utils.errors import DeviceAlreadyConnectedError, DeviceNotConnectedError
except ImportError:  # another version of LeRobot
    DeviceAlreadyConnectedError = DeviceNotConnectedError = ConnectionError


class FeltwireTeleoperator(HandTeleoperator, Teleoperator):
    """A hand of feltwire. feltwire.lerobot.HandTeleoperator documents it."""

    config_class = FeltwireTeleoperatorConfig
    name = "feltwire"
    _already_connected, _not_connected = DeviceAlreadyConnectedError, DeviceNotConnectedError

    def __init__(self, config: FeltwireTeleoperatorConfig):
        super().__init__(config)
        self.config = config

"""A hand of feltwire as a teleoperator of LeRobot: --teleop.type=feltwire.

LeRobot imports every installed distribution whose name begins with lerobot_teleoperator_, and finds the class FeltwireTeleoperator by the
name of its configuration.
"""
from .config_feltwire import FeltwireTeleoperatorConfig
from .feltwire import FeltwireTeleoperator

__all__ = ["FeltwireTeleoperator", "FeltwireTeleoperatorConfig"]

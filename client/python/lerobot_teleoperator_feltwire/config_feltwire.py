"""The options of the teleoperator: --teleop.server=HOST:PORT and so on."""
from dataclasses import dataclass, field
from typing import Any, Dict, Optional

from lerobot.teleoperators.config import TeleoperatorConfig


@TeleoperatorConfig.register_subclass("feltwire")
@dataclass(kw_only=True)
class FeltwireTeleoperatorConfig(TeleoperatorConfig):
    """device: as --device of feltwire-client. server, scene: the hand feels that scene; without a server it feels send_feedback().
    stiffness [N/m]: without a server, of the stiffest contact. record_feel: actions have the forces too. options: further keywords of
    feltwire.join() or feltwire.World, as {"max_force": 3}."""

    device: str = "simulated"
    server: str = ""
    scene: str = ""
    fingerprint_file: Optional[str] = None
    token_file: Optional[str] = None
    stiffness: float = 1000.0
    record_feel: bool = True
    options: Dict[str, Any] = field(default_factory=dict)

"""What a server may grant (PROTOCOL.md, "What a server may grant"), as a client judges it."""
import math

from model_ranges import wrong_parameter
from schema import CONTROL

FREE = ("packet_interval", "redundancy", "batch", "position_deadband", "force_deadband", "predictor", "local_model")
DEFAULTS = {field.name: field.default for field in CONTROL.tables["SessionParameters"].fields if field.kind == "scalar"}


def same(a, b):
    return a == b or (isinstance(a, float) and isinstance(b, float) and math.isnan(a) and math.isnan(b))


def unit(vector):
    return abs(sum(part * part for part in vector.values()) - 1) <= 1e-3


def wrong_grant(request, joined):
    """The field that no server may grant like this, with both values; None if the client may take the grant."""
    wanted, granted = {**DEFAULTS, "mode": None, **request["parameters"]}, joined.parameters
    for name, value in granted.items():
        old = wanted[name]
        if name in FREE or same(old, value):
            continue
        allowed = (name == "hold_time" and min(0.1, old) <= value <= old) or (
            name == "keep_alive" and 0 <= value <= max(granted.hold_time / 2, old)) or (name == "side" and old == 0 and value == 1)
        if not allowed:
            return f"{name}: {old} was requested, {value} is granted"
    field = wrong_parameter(granted)
    if field:
        return f"{field} is out of its range"
    start = joined.start_position or {}
    tests = {"session": joined.session != 0, "silence_timeout": 0.1 <= joined.silence_timeout <= 3600,
             "start_position": all(abs(part) <= 1000 for part in start.values()),
             "start_normal": joined.start_normal is None or unit(joined.start_normal), "stiffness": 0 <= joined.stiffness <= 1e9,
             "suite": joined.suite in (1, 2), "tool": not request.get("tool") or joined.tool == request["tool"]}
    return next((f"{name}: {joined[name]} is granted" for name, right in tests.items() if not right), None)

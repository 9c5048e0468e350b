"""The ranges of a session's parameters and of a device, as the tables of PROTOCOL.md have them."""
import math

from control import SIDES

METHODS = ("none", "total_energy", "per_axis", "per_axis_projected", "contact_frame", "shaped", "midpoint", "credited", "virtual_coupling",
           "passivity_control", "passivity_control_parallel", "passivity_control_directional", "energy_tank")
RANGES = {  # of the table of session parameters
    "servo_period": (1e-5, 0.1), "redundancy": (0, 8), "operator_damping": (0, 100), "velocity_cutoff": (0, 1e5), "hold_time": (None, 1.0),
    "c1": (0, 1e9), "c2": (0, 1e9), "coupling_stiffness": (0, 1e9), "coupling_damping": (0, 1e6), "tool_mass": (1e-6, 1e3),
    "packet_interval": (1, 1000), "batch": (1, 9), "position_deadband": (0, 0.5), "force_deadband": (0, 0.5), "keep_alive": (0, 1)}
NAN_ALLOWED = ("c1", "c2", "coupling_stiffness", "coupling_damping")


def wrong_parameter(parameters, wrong=()):
    """The name of a field that is out of its range; None if all are within. `wrong`: deviations of a mutant."""
    one = {**parameters, "mode": parameters.mode or "contact_frame"}
    for name, (low, high) in RANGES.items():
        low = one["servo_period"] if low is None else low
        if not (low <= one[name] <= high or (name in NAN_ALLOWED and math.isnan(one[name]))):
            return name
    if one["mode"] not in METHODS:
        return "mode" if "methods_hidden" in wrong else "mode: choose one of " + " ".join(METHODS)
    needs = {"virtual_coupling": "server", "passivity_control_parallel": "server", "shaped": "client", "midpoint": "client",
             "credited": "client"}
    if "any_side" not in wrong and one["mode"] in needs and one["side"] != SIDES[needs[one["mode"]]]:
        return "side"
    if one["local_model"] and one["side"] == SIDES["server"] and "model_anyhow" not in wrong:
        return "local_model"
    if one["packet_interval"] * one["servo_period"] > one["hold_time"] * (1 + 1e-12):
        return "packet_interval"
    if one["batch"] > one["packet_interval"] or one["batch"] + one["redundancy"] > 9:
        return "batch"
    banded = [one["position_deadband"] > 0, one["force_deadband"] > 0]
    if any(banded):
        most = one["hold_time"] / (4 if all(banded) else 2)
        if not one["packet_interval"] * one["servo_period"] <= one["keep_alive"] <= most:
            return "keep_alive"
    return None


DEVICE_RANGES = {
    "damping": (0, 1000), "rotational_damping": (0, 100), "apparent_mass": (0, 1000), "coulomb_friction": (0, 10000),
    "position_resolution": (0, 0.01), "max_force": (0, 10000), "continuous_force": (0, 10000), "max_torque": (0, 1000)}


def wrong_device(device):
    """The name of a field of a device that is out of its range; None if all are within."""
    if not 1 <= len(device.name.encode()) <= 100:
        return "name"
    if device.translation_dof not in (2, 3):
        return "translation_dof"
    for field in ("rotation_sensed", "rotation_actuated"):
        if device[field] not in (0, 3):
            return field
    if device.rotation_actuated > device.rotation_sensed:
        return "rotation_actuated"
    for field, (low, high) in DEVICE_RANGES.items():
        if not low <= device[field] <= high:
            return field
    if device.max_torque != 0 and device.rotation_actuated == 0:
        return "max_torque"
    if device.max_force == 0:
        return "max_force"
    if device.continuous_force > device.max_force:
        return "continuous_force"
    if not all(0 <= part <= 100 for part in (device.workspace or {}).values()):
        return "workspace"
    return None

#pragma once
// The stiffest surface that a device's encoders allow: quantization against dry friction.

#include <optional>
#include <string>

#include "core/device/device_spec.hpp"

namespace feltwire {

/// [N/m] 2 f_c / quantum, the stiffest spring whose quantized position the device's Coulomb
/// friction f_c pays for. Over one quantum a spring K can give the energy K quantum^2 / 2 that no
/// encoder sees, and friction burns f_c quantum; at this K the two are equal. No value where the
/// device names no quantum. Source: Diolaiti, Niemeyer, Barbagli, Salisbury, "Stability of haptic
/// rendering: discretization, quantization, time delay, and Coulomb effects", IEEE Trans. Robotics,
/// 2006.
std::optional<double> encoder_stiffness_limit(const DeviceSpec& spec);

/// One sentence with numbers and remedy where the scene's stiffest surface [N/m] is above that
/// limit. The bound cannot see this energy: it counts the movement that the encoders report.
std::optional<std::string> encoder_warning(const DeviceSpec& spec, double scene_stiffness);

}  // namespace feltwire

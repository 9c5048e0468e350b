#pragma once
// The stiffest surface that a device's encoders allow: quantization against dry friction.

#include <optional>
#include <string>

#include "core/device/device_spec.hpp"

namespace feltwire {

/// [N/m] the stiffest spring whose quantized position the device's Coulomb friction pays for:
/// 2 f_c / quantum. Over one quantum a spring K can give K quantum^2 / 2 that no encoder sees, and
/// friction burns f_c quantum, so that this is where the two are equal. None
/// where the device names no quantum.
/// Source: Diolaiti, Niemeyer, Barbagli, Salisbury, "Stability of haptic rendering: discretization,
/// quantization, time delay, and Coulomb effects", IEEE Trans. Robotics, 2006.
std::optional<double> encoder_stiffness_limit(const DeviceSpec& spec);

/// One sentence with numbers and remedy where the scene's stiffest surface [N/m] is above that.
/// The bound does not see it: it accounts the movement that the encoders tell.
std::optional<std::string> encoder_warning(const DeviceSpec& spec, double scene_stiffness);

}  // namespace feltwire

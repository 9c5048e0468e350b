#pragma once
// The stiffest surface that a device's encoders allow: quantization against dry friction.

#include <optional>
#include <string>

#include "core/device/device_spec.hpp"

namespace feltwire {

/// [N/m] 2 f_c / quantum, the stiffest spring for which the device's Coulomb friction f_c covers
/// the energy of quantization. Over one quantum a spring K can give the energy K quantum^2 / 2 that
/// no encoder measures, and friction burns f_c quantum; at this K the two are equal. Empty if the
/// device has no quantum. Source: Diolaiti, Niemeyer, Barbagli, Salisbury, "Stability of haptic
/// rendering: discretization, quantization, time delay, and Coulomb effects", IEEE Trans. Robotics,
/// 2006.
std::optional<double> encoder_stiffness_limit(const DeviceSpec& spec);

/// A sentence with numbers and remedy if the scene's stiffest surface [N/m] is above that limit.
/// The bound cannot detect this energy, because it counts the movement that the encoders report.
std::optional<std::string> encoder_warning(const DeviceSpec& spec, double scene_stiffness);

}  // namespace feltwire

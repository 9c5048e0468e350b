#pragma once
// The assumptions of an account, from the specification of a device.

#include "core/bounding/account.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// The cap of the account, in multiples of the energy need of the device's largest force at rest.
inline constexpr double kAccountCap = 3.0;

/// For a force whose shaping guarantees nothing, at a servo period T [s]: the device's damping, the
/// lower bounds of its mass and dry friction, the largest force from outside and the largest speed.
/// For rotation the damping, the inertia and the largest torque from outside.
AccountConfig account_config(const DeviceSpec& spec, double period);

/// For a force whose bound is passive on its own: the device's damping, no property of the hand, no
/// cap, no look ahead. It cuts if the specification of that bound is wrong, or ticks are late.
AccountConfig any_hand_account(const DeviceSpec& spec, double period);

}  // namespace feltwire

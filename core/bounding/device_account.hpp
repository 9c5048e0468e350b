#pragma once
// What an account may count on, from the specification of a device.

#include "core/bounding/account.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// The cap of the account, in times of what the device's largest force needs at rest.
inline constexpr double kAccountCap = 3.0;

/// For a force whose shaping promises nothing, at a servo period T [s]: the device's damping, the
/// lower bounds of its mass and dry friction, the largest force from outside and speed. Of rotation
/// the damping, the inertia and the largest torque from outside.
AccountConfig account_config(const DeviceSpec& spec, double period);

/// For a force whose bound is passive by itself: the device's damping and nothing of the hand, no
/// cap, no look ahead. It cuts where that bound was told something wrong, or ticks came late.
AccountConfig any_hand_account(const DeviceSpec& spec, double period);

}  // namespace feltwire

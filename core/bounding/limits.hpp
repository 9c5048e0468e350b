#pragma once
// Values beyond these limits are no force and no movement of a hand, but an upstream fault. The
// limits also keep every product in a bound finite, in float too.

namespace feltwire {

/// [N], [N m] a command with a component beyond it is refused.
inline constexpr double kLargestForce = 1e12;
inline constexpr double kLargestMovement = 1e6;    // [m], [rad]
inline constexpr double kLargestHold = 1e6;        // [s]
inline constexpr double kLargestStiffness = 1e18;  // [N/m], [N m/rad]

}  // namespace feltwire

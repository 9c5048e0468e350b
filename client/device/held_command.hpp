#pragma once
// Splits the force that a device reports as held into the elastic and frictional parts of its
// command.

#include <algorithm>

#include "core/base/types.hpp"

namespace feltwire {

/// The share of what was asked for, 0 to 1, that is in a real force (or torque) along it; 0 where
/// nothing was asked for.
inline double held_share(const Vec3& real, const Vec3& asked) noexcept {
  const double square = asked.squaredNorm();
  return square > 0.0 ? std::clamp(real.dot(asked) / square, 0.0, 1.0) : 0.0;
}

/// Returns the command whose sum is `force` [N] and `torque` [N m]. It has the parts of `asked` as
/// far as they explain the force. The sum is exact.
inline Command held_command(const Command& asked, const Vec3& force, const Vec3& torque) noexcept {
  const Vec3 wanted = asked.force();
  if (force == wanted && torque == asked.torque) return asked;
  const Vec3 frictional = held_share(force, wanted) * asked.frictional;
  return {.elastic = force - frictional, .frictional = frictional, .torque = torque};
}

}  // namespace feltwire

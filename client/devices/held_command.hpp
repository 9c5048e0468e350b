#pragma once
// Splits the force that a device reports as held into the elastic and frictional parts of its
// command.

#include <algorithm>

#include "core/base/types.hpp"

namespace feltwire {

/// Returns the command whose sum is `force` [N] and `torque` [N m]. It has the parts of `asked` as
/// far as they explain the force. The sum is exact.
inline Command held_command(const Command& asked, const Vec3& force, const Vec3& torque) noexcept {
  const Vec3 wanted = asked.force();
  if (force == wanted && torque == asked.torque) return asked;
  const double square = wanted.squaredNorm();
  const double share = square > 0.0 ? std::clamp(force.dot(wanted) / square, 0.0, 1.0) : 0.0;
  const Vec3 frictional = share * asked.frictional;
  return {.elastic = force - frictional, .frictional = frictional, .torque = torque};
}

}  // namespace feltwire

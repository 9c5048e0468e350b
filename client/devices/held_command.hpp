#pragma once
// Splits the one force that a device says it holds into the elastic and frictional parts of the
// command that it was given.

#include <algorithm>

#include "core/base/types.hpp"

namespace feltwire {

/// The command of which `force` [N] and `torque` [N m] are on the hand: the parts of `asked`, as
/// far as that explains the force. The sum is exact.
inline Command held_command(const Command& asked, const Vec3& force, const Vec3& torque) noexcept {
  const Vec3 wanted = asked.force();
  if (force == wanted && torque == asked.torque) return asked;
  const double square = wanted.squaredNorm();
  const double share = square > 0.0 ? std::clamp(force.dot(wanted) / square, 0.0, 1.0) : 0.0;
  const Vec3 frictional = share * asked.frictional;
  return {.elastic = force - frictional, .frictional = frictional, .torque = torque};
}

}  // namespace feltwire

#pragma once
// The command that a device really held: its parts, and its mean over time.

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

/// Returns of_a * a + of_b * b, part by part: the mean command over two times with these shares.
inline Command weighted(const Command& a, double of_a, const Command& b, double of_b) noexcept {
  return {of_a * a.elastic + of_b * b.elastic, of_a * a.frictional + of_b * b.frictional,
          of_a * a.torque + of_b * b.torque};
}

}  // namespace feltwire

#pragma once
// The one port of the laws of other papers, for a contact in three dimensions.

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// A command as a force that presses along the contact's normal, and the movement along it. The
/// papers treat one degree of freedom. Our choice is to scale the rest of the command by the same
/// factor, which keeps the direction.
struct ContactForce {
  double wanted = 0.0;  // [N] F_e(n) >= 0, along the normal
  double inward = 0.0;  // [m] dx(n) into the surface
  Vec3 normal;          // u, out of the surface; zero without an elastic force
  Command command;

  explicit ContactForce(const BoundingStep& s)
      : normal(direction(s.command.elastic)), command(s.command) {
    wanted = std::max(0.0, s.command.force().dot(normal));
    inward = -s.displacement.dot(normal);
  }
  /// The command with `force` [N] along the normal.
  Command rendered(double force) const noexcept {
    const double share = wanted > 0.0 ? std::clamp(force / wanted, 0.0, 1.0) : 0.0;
    return {share * command.elastic, share * command.frictional, Vec3::Zero()};
  }
};

}  // namespace feltwire

#pragma once

#include "core/bounding/per_axis.hpp"

namespace feltwire {

/// (F . u) u with u = F_e / |F_e|  // Eq. (3)
inline Vec3 projected(const Vec3& bounded, const Vec3& command) noexcept {
  return along(bounded, direction(command));
}

/// mode `per_axis_projected`, the paper's method (Fig. 6): the per-axis bound, then the projection
/// onto the commanded direction, force and torque apart. Per axis the bounded force lies between
/// the held one and the command or beyond zero, so F_d . u may be negative (a pull the scene never
/// commanded): that is faithful to Eq. (3) and kept. Known weakness: the projected force is no
/// longer inside its per-axis bounds, friction on one axis pays for force on another, and at
/// moderate damping a stiff wall with friction buzzes again (docs/bounding.md).
struct ProjectedBound {
  PerAxisBound per_axis;

  Command step(const BoundingStep& s) noexcept {
    const Vec3 command = s.command.force();
    const Vec3 bounded =
        eba_axes(command, s.displacement, per_axis.held_force, per_axis.translation);
    Command rendered = split_along(projected(bounded, command), s.command.elastic);
    if (per_axis.torque) {
      rendered.torque =
          projected(eba_axes(s.command.torque, s.rotation, per_axis.held_torque, per_axis.rotation),
                    s.command.torque);
    }
    return rendered;
  }
  /// F_d(n-1) of the next step is what was really rendered: after the projection.
  void set_held(const Command& held) noexcept { per_axis.set_held(held); }
};

}  // namespace feltwire

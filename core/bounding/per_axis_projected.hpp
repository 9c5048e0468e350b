#pragma once

#include "core/bounding/per_axis.hpp"

namespace feltwire {

/// (F . u) u with u = F_e / |F_e|  // Eq. (3)
template <class Real>
inline Vector3<Real> projected(const Vector3<Real>& bounded,
                               const Vector3<Real>& command) noexcept {
  return along(bounded, direction(command));
}

/// mode `per_axis_projected`, the paper's method (Fig. 6): the per-axis bound, then the projection
/// onto the commanded direction, force and torque apart. On each axis the bounded force lies
/// between the held one and the command or beyond zero. So F_d . u may be negative (a pull that the
/// scene never commanded); this follows Eq. (3) and is kept. Known weakness: the projected force is
/// no longer inside its per-axis bounds, friction on one axis pays for force on another, and at
/// moderate damping a stiff wall with friction buzzes again (docs/bounding.md).
template <class Real>
struct ProjectedBound {
  PerAxisBound<Real> axes;

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    const Vector3<Real> command = s.command.force();
    const Vector3<Real> bounded =
        axes.translation.bounded(command, s.displacement, axes.held_force);
    BasicCommand<Real> rendered = split_along(projected(bounded, command), s.command.elastic);
    if (axes.torque)
      rendered.torque = projected(
          axes.rotation.bounded(s.command.torque, s.rotation, axes.held_torque), s.command.torque);
    set_held(rendered);
    return rendered;
  }
  /// F_d(n-1) of the next step is the force that was really rendered, after the projection.
  void set_held(const BasicCommand<Real>& held) noexcept { axes.set_held(held); }
};

}  // namespace feltwire

#pragma once
// The paper's multi-dof EBA: control law and bounding laws of its section 2, axis by axis (Eq. 2).

#include <algorithm>
#include <cmath>

#include "core/bounding/split.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// The paper's bounding constants of one port, 0 <= c2 <= c1 [N/m or N m/rad].
struct EbaConstants {
  double c1 = 0.0;  // beta_max: what the device's own damping burns in one sample, b/T
  double c2 = 0.0;  // stiffness of the storage S(F) = F^2 / (2 c2)
};

/// Interval of forces that the bounding laws allow on one axis.
struct ForceInterval {
  double lo, hi;
};

/// One axis, in the paper's sign F = -f (F dx > 0 flows into the controller).
///
/// Printed (with c2 squared, see docs/bounding.md):  F_d(n) = F_d(n-1) + beta(n) dx(n),
///   beta_max = min(c1, gamma_max),  beta_min = gamma_min,
///   gamma_max/min = c2 - F_d(n-1)/dx +- sqrt(c2^2 + (F_d(n-1)/dx)^2).
/// Multiplied out by dx, so that nothing is divided by it: with a = c2 dx, h = hypot(a, F_p),
///   hi = a + h, lo = a - h, and F_p + beta_max dx from the side that dx points to.
/// It is F(n) dx(n) >= (F(n)^2 - F(n-1)^2) / (2 c2) and (F(n) - F(n-1)) dx(n) <= c1 dx(n)^2.
inline ForceInterval eba_interval(double dx, double held, EbaConstants c) noexcept {
  const double a = c.c2 * dx;
  const double h = hypotenuse(a, held);
  // The side where a and h would cancel uses (h + a)(h - a) = held^2, divided in an order that
  // cannot overflow.
  double hi = a >= 0.0 ? a + h : std::abs(held) * (std::abs(held) / (h - a));
  double lo = a <= 0.0 ? a - h : -std::abs(held) * (std::abs(held) / (h + a));
  if (dx > 0.0) hi = std::min(hi, held + c.c1 * dx);
  if (dx < 0.0) lo = std::max(lo, held + c.c1 * dx);
  return {lo, hi};
}

/// One axis: the command clamped into what the bounding laws allow (paper's sign).
inline double eba_axis(double command, double dx, double held, EbaConstants c) noexcept {
  const ForceInterval allowed = eba_interval(dx, held, c);
  // c2 <= c1 keeps lo <= hi; should rounding cross the two by an ulp, either is right to rounding.
  return std::max(allowed.lo, std::min(allowed.hi, command));
}

/// Three axes at once; vectors on the hand (f = -F).
inline Vec3 eba_axes(const Vec3& command, const Vec3& displacement, const Vec3& held,
                     EbaConstants c) noexcept {
  Vec3 rendered;
  for (int i = 0; i < 3; ++i) rendered[i] = -eba_axis(-command[i], displacement[i], -held[i], c);
  return rendered;
}

/// mode `per_axis`: every axis of the fixed global frame is passive by itself (Eq. 2); the paper's
/// Fig. 3 and Fig. 5. Known weakness: on a curved surface the force moves energy between the axes
/// without creating any; this law forbids that, and the rendered direction bends.
struct PerAxisBound {
  EbaConstants translation, rotation;
  bool torque = false;
  Vec3 held_force = Vec3::Zero();
  Vec3 held_torque = Vec3::Zero();

  Command step(const BoundingStep& s) noexcept {
    const Vec3 force = eba_axes(s.command.force(), s.displacement, held_force, translation);
    Command rendered = split_along(force, s.command.elastic);
    if (torque) rendered.torque = eba_axes(s.command.torque, s.rotation, held_torque, rotation);
    return rendered;
  }
  void set_held(const Command& held) noexcept {
    held_force = held.force();
    held_torque = held.torque;
  }
};

}  // namespace feltwire

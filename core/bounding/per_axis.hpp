#pragma once
// The paper's multi-dof EBA: control law and bounding laws of its section 2, axis by axis (Eq. 2).

#include <algorithm>
#include <array>
#include <cmath>

#include "core/bounding/split.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// The paper's bounding constants of one axis, 0 <= c2 <= c1 [N/m or N m/rad].
template <class Real>
struct BasicEbaConstants {
  Real c1 = 0;  // beta_max: the energy that the device's own damping burns in one sample, b/T
  Real c2 = 0;  // stiffness of the storage S(F) = F^2 / (2 c2)
};
using EbaConstants = BasicEbaConstants<double>;

/// Interval of forces that the bounding laws allow on one axis.
template <class Real>
struct ForceInterval {
  Real lo, hi;
};

/// A single axis, in the paper's sign F = -f (F dx > 0 flows into the controller).
///
/// Printed (with c2 squared, see docs/bounding.md):  F_d(n) = F_d(n-1) + beta(n) dx(n),
///   beta_max = min(c1, gamma_max),  beta_min = gamma_min,
///   gamma_max/min = c2 - F_d(n-1)/dx +- sqrt(c2^2 + (F_d(n-1)/dx)^2).
/// Multiplied out by dx, so that nothing is divided by it: with a = c2 dx, h = hypot(a, F_p),
///   hi = a + h, lo = a - h, and F_p + beta_max dx on the side of dx.
/// It is F(n) dx(n) >= (F(n)^2 - F(n-1)^2) / (2 c2) and (F(n) - F(n-1)) dx(n) <= c1 dx(n)^2.
template <class Real>
inline ForceInterval<Real> eba_interval(Real dx, Real held, BasicEbaConstants<Real> c) noexcept {
  const Real a = c.c2 * dx;
  const Real h = hypotenuse(a, held);
  // On the side where a and h would cancel it uses (h + a)(h - a) = held^2, divided in an order
  // that cannot overflow.
  const Real other = std::abs(held) * (std::abs(held) / (h + std::abs(a)));
  Real hi = a >= 0 ? a + h : other;
  Real lo = a <= 0 ? a - h : -other;
  if (dx > 0) hi = std::min(hi, held + c.c1 * dx);
  if (dx < 0) lo = std::max(lo, held + c.c1 * dx);
  return {lo, hi};
}

/// A single axis: clamps the command into the interval of the bounding laws (paper's sign).
template <class Real>
inline Real eba_axis(Real command, Real dx, Real held, BasicEbaConstants<Real> c) noexcept {
  const ForceInterval<Real> allowed = eba_interval(dx, held, c);
  // c2 <= c1 keeps lo <= hi. If rounding crosses the two by an ulp, both are right within rounding.
  return std::max(allowed.lo, std::min(allowed.hi, command));
}

/// The constants of one port, axis by axis.
template <class Real>
struct EbaAxes {
  std::array<BasicEbaConstants<Real>, 3> axis;

  /// Uses these constants on every axis.
  static EbaAxes uniform(BasicEbaConstants<Real> c) { return {{c, c, c}}; }

  /// Three axes at once; vectors on the hand (f = -F).
  Vector3<Real> bounded(const Vector3<Real>& command, const Vector3<Real>& displacement,
                        const Vector3<Real>& held) const noexcept {
    Vector3<Real> rendered;
    for (int i = 0; i < 3; ++i)
      rendered[i] =
          -eba_axis(-command[i], displacement[i], -held[i], axis[static_cast<std::size_t>(i)]);
    return rendered;
  }
};

/// mode `per_axis`: every axis of the fixed global frame is passive by itself (Eq. 2); the paper's
/// Fig. 3 and Fig. 5. Known weakness: on a curved surface the force moves energy between the axes
/// without creating any; this law forbids that, and the rendered direction bends.
template <class Real>
struct PerAxisBound {
  EbaAxes<Real> translation, rotation;
  bool torque = false;
  Vector3<Real> held_force = Vector3<Real>::Zero();
  Vector3<Real> held_torque = Vector3<Real>::Zero();

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    held_force = translation.bounded(s.command.force(), s.displacement, held_force);
    BasicCommand<Real> rendered = split_along(held_force, s.command.elastic);
    if (torque)
      rendered.torque = held_torque = rotation.bounded(s.command.torque, s.rotation, held_torque);
    return rendered;
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    held_force = held.force();
    held_torque = held.torque;
  }
};

}  // namespace feltwire

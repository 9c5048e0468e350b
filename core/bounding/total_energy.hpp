#pragma once

#include "core/bounding/per_axis.hpp"

namespace feltwire {

/// mode `total_energy`: the per-axis clamp, but only at samples where the energy that flowed in
/// over all axes, T sum_k { F_1(k) v_1(k) + ... + F_n(k) v_n(k) }, would become negative (Eq. 1).
/// The paper's Fig. 2. Known weakness: friction on one axis keeps the total positive while another
/// axis oscillates; it never acts.
template <class Real>
struct TotalEnergyBound {
  PerAxisBound<Real> axes;
  Real energy_before = 0;  // [J] sum of F(k) . dx(k) up to the sample before
  Real energy_in =
      0;  // [J] and with this sample, the paper's T F(k) v(k), for the force really held
  Vector3<Real> displacement = Vector3<Real>::Zero(), rotation = Vector3<Real>::Zero();  // last

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    energy_before = energy_in;
    displacement = s.displacement;
    rotation = s.rotation;
    const bool passive = energy_before + inflow(s.command) >= 0;  // Eq. (1) holds: nothing to do
    BasicCommand<Real> rendered = passive ? s.command : axes.step(s);
    set_held(rendered);
    return rendered;
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    energy_in = energy_before + inflow(held);
    axes.set_held(held);
  }

 private:
  /// F(n) . dx(n) [J], paper's sign.
  Real inflow(const BasicCommand<Real>& c) const noexcept {
    return -c.force().dot(displacement) - (axes.torque ? c.torque.dot(rotation) : Real(0));
  }
};

}  // namespace feltwire

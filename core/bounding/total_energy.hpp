#pragma once

#include "core/bounding/per_axis.hpp"

namespace feltwire {

/// mode `total_energy`: the per-axis clamp, but only at samples where the energy that flowed in
/// over all axes, T sum_k { F_1(k) v_1(k) + ... + F_n(k) v_n(k) }, would become negative (Eq. 1).
/// The paper's Fig. 2. Known weakness: friction on one axis keeps the total positive while another
/// axis oscillates; it never acts.
struct TotalEnergyBound {
  PerAxisBound per_axis;
  double energy_before = 0.0;  // [J] sum of F(k) . dx(k) up to the sample before
  double energy_in =
      0.0;  // [J] and with this sample, the paper's T F(k) v(k), at what was really held
  BoundingStep last{};

  Command step(const BoundingStep& s) noexcept {
    energy_before = energy_in;
    last = s;
    if (energy_before + inflow(s.command) >= 0.0) return s.command;  // Eq. (1) holds: nothing to do
    return per_axis.step(s);
  }
  void set_held(const Command& held) noexcept {
    energy_in = energy_before + inflow(held);
    per_axis.set_held(held);
  }

 private:
  /// F(n) . dx(n) [J], paper's sign.
  double inflow(const Command& c) const noexcept {
    return -c.force().dot(last.displacement) -
           (per_axis.torque ? c.torque.dot(last.rotation) : 0.0);
  }
};

}  // namespace feltwire

#pragma once
// Mass, delay and, as a cross-check, damping, from the impulse of a sweep by least squares.

#include "client/identify/sweep_record.hpp"

namespace feltwire {

/// force = m a + b v + f_c sign v + g along the sweep, the reading `delay` behind the force.
struct ImpulseFit {
  double mass = 0.0, mass_error = 0.0;        // [kg]
  double damping = 0.0, damping_error = 0.0;  // [N s/m]
  double friction = 0.0;                      // [N]
  double delay = 0.0;                         // [s] the one that fits best
  bool valid = false;                         // it moved enough for an estimate
};

/// Delays up to 8 ms are tried, in steps of 0.25 ms.
ImpulseFit impulse_fit(const SweepRecord& run);

}  // namespace feltwire

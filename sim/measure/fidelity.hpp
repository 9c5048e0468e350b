#pragma once
// Compares the force on a hand with the scene's force at the hand's true place.

#include <span>

#include "sim/measure/experiment_metrics.hpp"
#include "sim/measure/network_run.hpp"

namespace feltwire {

struct Fidelity {
  double error = 0.0;                    // [N] RMS of held less ideal
  double felt = 0.0;                     // [N] RMS of ideal
  double held_sum = 0.0, ideal_sum = 0;  // [N] of the magnitudes
  Spread direction;                      // [rad] between the two, where both are above 1 mN

  double relative_error() const { return felt > 0.0 ? error / felt : 0.0; }
  double ratio() const { return ideal_sum > 0.0 ? held_sum / ideal_sum : 0.0; }
};
Fidelity fidelity(std::span<const NetworkSample> samples);

/// [m] The oscillation of the hand: highpass_rms() of the true position, on the axis where it is
/// largest, at a servo rate of `rate` [Hz].
double oscillation(std::span<const NetworkSample> samples, double rate);

}  // namespace feltwire

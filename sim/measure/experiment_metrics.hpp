#pragma once
// The measures for the paper's figures.

#include <numbers>
#include <span>
#include <vector>

#include "core/bounding/per_axis.hpp"
#include "sim/measure/experiment.hpp"

namespace feltwire {

inline constexpr double kDegrees = 180.0 / std::numbers::pi;  // in a radian

/// [rad], 0 to pi; correct for every angle. 0 if one has no direction.
double angle_between(const Vec3& a, const Vec3& b);

struct Spread {
  double mean = 0.0, p99 = 0.0, max = 0.0;
};
/// Mean, 99th percentile (nearest rank) and maximum; zeros if there is no value.
Spread spread(std::vector<double> values);

/// The median; for an even number the mean of the two in the middle; 0 if there is no value.
double median(std::vector<double> values);

/// The oscillation of a value: the RMS [unit of the values] of the values less their centred moving
/// average over kOscillationWindow, over the second half of the run. The values are sampled at
/// `rate` [Hz]. The ends that the window does not cover are left out. 0 for a run shorter than two
/// windows. The client's report has the same measure (client/servo/feel_metrics.hpp).
double highpass_rms(std::span<const double> values, double rate);

struct ExperimentMetrics {
  Vec3 highpass_rms = Vec3::Zero();  // [m] of the true position, axis by axis
  // Flow-in with the pairing of the bounding laws and Eq. (1), (2): sum of F_i(k) dx_i(k), force
  // with the motion before it.
  Vec3 min_energy = Vec3::Zero();  // [J] least value over time, axis by axis
  double total_energy = 0.0;       // [J] at the end, over all axes
  // Flow-in as the port really exchanged it under the zero-order hold: sum of F_i(k-1) dx_i(k). The
  // two differ by the energy that the hold creates: with the first pairing a sampled spring is
  // always positive, however it buzzes (docs/lab/figures.md).
  Vec3 min_port_energy = Vec3::Zero();  // [J]
  double port_energy = 0.0;             // [J] at the end, over all axes
  double min_port_margin =
      0.0;  // [J] least (burned by the device - delivered to the hand) under the real hold
  Spread direction_error;    // [rad] between rendered and commanded force, where there are both
  double force_ratio = 0.0;  // mean |F_d| / |F_e| where a force is commanded
  double outside_bounds_share =
      0.0;  // of the commanded samples: rendered force outside its per-axis interval
};

/// `constants` are those of the per-axis interval, `damping` [N s/m] and `period` [s] those of the
/// real port.
ExperimentMetrics measure(std::span<const ExperimentSample> samples, EbaConstants constants,
                          const Damping& damping, double period);

}  // namespace feltwire

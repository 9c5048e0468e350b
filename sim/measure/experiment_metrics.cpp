#include "sim/measure/experiment_metrics.hpp"

#include <algorithm>
#include <cmath>
#include <numeric>

#include "core/base/centred_highpass.hpp"
#include "core/bounding/port_energy.hpp"

namespace feltwire {
namespace {

constexpr double kFelt = 1e-6;  // [N] no direction error is computed for smaller forces

/// Returns true if the rendered force on an axis is outside the interval of Eq. (2) by more than
/// the rounding error. Eq. (2) is the per-axis limit of the energy-bounding algorithm.
bool outside(const ExperimentSample& s, const Vec3& rendered, EbaConstants constants) {
  const double tolerance = 1e-9 * std::max(rendered.norm(), s.held.norm());
  for (int i = 0; i < 3; ++i) {
    const ForceInterval allowed = eba_interval(s.displacement[i], -s.held[i], constants);
    if (-rendered[i] < allowed.lo - tolerance || -rendered[i] > allowed.hi + tolerance) return true;
  }
  return false;
}

}  // namespace

double angle_between(const Vec3& a, const Vec3& b) {
  return std::atan2(a.cross(b).norm(), a.dot(b));
}

Spread spread(std::vector<double> values) {
  if (values.empty()) return {};
  std::sort(values.begin(), values.end());
  const auto rank = static_cast<std::size_t>(std::ceil(0.99 * static_cast<double>(values.size())));
  return {std::accumulate(values.begin(), values.end(), 0.0) / static_cast<double>(values.size()),
          values[std::max<std::size_t>(rank, 1) - 1], values.back()};
}

double median(std::vector<double> values) {
  if (values.empty()) return 0.0;
  std::sort(values.begin(), values.end());
  const std::size_t half = values.size() / 2;
  return values.size() % 2 ? values[half] : 0.5 * (values[half - 1] + values[half]);
}

double highpass_rms(std::span<const double> values, double rate) {
  const std::size_t wide = odd_window(kOscillationWindow, rate), half = wide / 2;
  if (values.size() < 2 * wide) return 0.0;
  const std::size_t begin = std::max(values.size() / 2, half), end = values.size() - half;
  CentredHighPass filter(wide);
  double squares = 0.0;
  for (std::size_t n = begin - half; n < end + half; ++n) {
    const double fast = filter.push(values[n]).value_or(0.0);
    squares += fast * fast;
  }
  return std::sqrt(squares / static_cast<double>(end - begin));
}

ExperimentMetrics measure(std::span<const ExperimentSample> samples, EbaConstants constants,
                          const Damping& damping, double period) {
  ExperimentMetrics m;
  PortEnergy port(damping, 0.0, period);
  Vec3 energy = Vec3::Zero(), port_energy = Vec3::Zero();
  std::vector<double> angles;
  double ratio_sum = 0.0;
  std::size_t commanded = 0, outside_count = 0;

  for (const ExperimentSample& s : samples) {
    const Vec3 rendered = s.rendered.force(), wanted = s.commanded.force();
    energy -= rendered.cwiseProduct(s.displacement);  // energy flow into the port: F dx with F = -f
    port_energy -= s.held.cwiseProduct(s.displacement);
    m.min_energy = m.min_energy.cwiseMin(energy);
    m.min_port_energy = m.min_port_energy.cwiseMin(port_energy);
    port.step({s.held, Vec3::Zero(), Vec3::Zero()}, s.displacement, Vec3::Zero(), period);

    if (wanted.norm() < kFelt) continue;
    ++commanded;
    ratio_sum += rendered.norm() / wanted.norm();
    if (rendered.norm() > kFelt) angles.push_back(angle_between(rendered, wanted));
    outside_count += outside(s, rendered, constants);
  }

  std::vector<double> axis(samples.size());
  for (int i = 0; i < 3; ++i) {
    for (std::size_t n = 0; n < samples.size(); ++n) axis[n] = samples[n].position[i];
    m.highpass_rms[i] = highpass_rms(axis, 1.0 / period);
  }
  m.total_energy = energy.sum();
  m.port_energy = port_energy.sum();
  m.min_port_margin = port.least_margin();
  m.direction_error = spread(std::move(angles));
  if (commanded > 0) {
    m.force_ratio = ratio_sum / static_cast<double>(commanded);
    m.outside_bounds_share = static_cast<double>(outside_count) / static_cast<double>(commanded);
  }
  return m;
}

}  // namespace feltwire

#include "sim/measure/fidelity.hpp"

#include <algorithm>
#include <cmath>
#include <vector>

namespace feltwire {

Fidelity fidelity(std::span<const NetworkSample> samples) {
  constexpr double kFelt = 1e-3;  // [N] no direction error is computed for smaller forces
  Fidelity result;
  std::vector<double> angles;
  for (const NetworkSample& s : samples) {
    const Vec3 held = s.held.force(), ideal = s.ideal.force();
    result.error += (held - ideal).squaredNorm();
    result.felt += ideal.squaredNorm();
    result.held_sum += held.norm();
    result.ideal_sum += ideal.norm();
    if (held.norm() > kFelt && ideal.norm() > kFelt) angles.push_back(angle_between(held, ideal));
  }
  if (samples.empty()) return result;
  const auto count = static_cast<double>(samples.size());
  result.error = std::sqrt(result.error / count);
  result.felt = std::sqrt(result.felt / count);
  result.direction = spread(std::move(angles));
  return result;
}

double oscillation(std::span<const NetworkSample> samples, double rate) {
  double most = 0.0;
  for (int axis = 0; axis < 3; ++axis) {
    std::vector<double> way;
    way.reserve(samples.size());
    for (const NetworkSample& s : samples) way.push_back(s.position[axis]);
    most = std::max(most, highpass_rms(way, rate));
  }
  return most;
}

}  // namespace feltwire

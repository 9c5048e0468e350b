#pragma once
// The path that trade studies and their scenes share: once round a ball, a little below its
// surface.

#include <cmath>
#include <numbers>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

inline constexpr double kGlideBall = 0.09, kGlideDepth = 2e-3;   // [m]
inline constexpr double kGlideStiffness = 5000.0;                // [N/m]
inline constexpr double kGlideSpeed = 0.1, kGlidePeriod = 1e-3;  // [m/s], [s]

/// Places on a tilted circle of a radius [m] about the origin, a period apart at that speed.
inline std::vector<Vec3> glide(double radius = kGlideBall - kGlideDepth) {
  const Vec3 u = Vec3(1.0, 0.3, 0.2).normalized();
  const Vec3 v = u.cross(Vec3(-0.2, 0.5, 1.0)).normalized();
  const double turn = 2.0 * std::numbers::pi;
  const auto samples = static_cast<std::size_t>(turn * radius / (kGlideSpeed * kGlidePeriod));
  std::vector<Vec3> path;
  for (std::size_t n = 0; n < samples; ++n) {
    const double angle = turn * static_cast<double>(n) / static_cast<double>(samples);
    path.push_back(radius * (std::cos(angle) * u + std::sin(angle) * v));
  }
  return path;
}

}  // namespace feltwire

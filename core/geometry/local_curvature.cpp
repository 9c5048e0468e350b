#include "core/geometry/local_curvature.hpp"

#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {

LocalCurvature local_curvature(const Vec3& u, const Vec3& v, double uu, double uv,
                               double vv) noexcept {
  // The principal curvatures are mean + half (along `first`) and mean - half (along `second`).
  const double mean = 0.5 * (uu + vv), half = hypotenuse(0.5 * (uu - vv), uv);
  const double most = mean + half, least = mean - half;
  const double turn = 0.5 * std::atan2(2.0 * uv, uu - vv);
  const Vec3 first = std::cos(turn) * u + std::sin(turn) * v;
  const Vec3 second = std::cos(turn) * v - std::sin(turn) * u;
  if (half <= std::abs(least) && half <= std::abs(most)) return {mean, Vec3::Zero()};
  if (std::abs(least) <= std::abs(most)) return {most, second};
  return {least, first};
}

}  // namespace feltwire

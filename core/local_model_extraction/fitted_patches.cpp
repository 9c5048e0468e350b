#include "core/local_model_extraction/fitted_patches.hpp"

#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {

Bend bend(const Vec3& u, const Vec3& v, double uu, double uv, double vv) noexcept {
  // Principal curvatures: mean +- half the difference, the first along `first`.
  const double mean = 0.5 * (uu + vv), half = hypotenuse(0.5 * (uu - vv), uv);
  const double most = mean + half, least = mean - half;
  const double turn = 0.5 * std::atan2(2.0 * uv, uu - vv);
  const Vec3 first = std::cos(turn) * u + std::sin(turn) * v;
  const Vec3 second = std::cos(turn) * v - std::sin(turn) * u;
  if (half <= std::abs(least) && half <= std::abs(most)) return {mean, Vec3::Zero()};
  if (std::abs(least) <= std::abs(most)) return {most, second};
  return {least, first};
}

FittedPatches fitted_patches(const Object& object, const Vec3& position,
                             const FeatureMemory& memory) noexcept {
  if (const auto* mesh = std::get_if<Mesh>(&object.shape))
    return mesh_patches(*mesh->surface, object.felt_from, position, memory);
  if (const auto* grid = std::get_if<Grid>(&object.shape))
    return grid_patches(*grid, object.felt_from, position);
  return {};
}

double fitted_radius(const Object& object, const FittedPatches& fitted, int count,
                     int index) noexcept {
  if (const auto* mesh = std::get_if<Mesh>(&object.shape))
    return mesh_patch_radius(*mesh->surface, fitted, count, index);
  return fitted.extent;
}

}  // namespace feltwire

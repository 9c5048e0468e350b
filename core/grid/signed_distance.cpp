#include "core/grid/signed_distance.hpp"

#include <limits>
#include <stdexcept>
#include <string>

namespace feltwire {
namespace {

/// Returns the signed distance from the solid. Ignores on which side (outside or inside) the tool
/// feels the surface.
FieldPoint of_solid(const Shape& shape, const Vec3& p) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape)) return grid->field->at(p);
  return on_primitive(
      shape, [&](const auto& solid) { return solid.signed_distance(p); },
      [] {
        return FieldPoint{std::numeric_limits<double>::quiet_NaN(), Vec3::Zero()};
      });
}

/// Returns half the side lengths [m] of the bounding box.
Vec3 half_box(const Shape& shape) {
  if (std::holds_alternative<Mesh>(shape))
    throw std::invalid_argument("a mesh has a sampling of its own (mesh_distance.hpp)");
  return on_primitive(
      shape,
      [](const auto& solid) {
        if (is_bounded(solid)) return solid.half_box();
        throw std::invalid_argument("a " + std::string(solid.kName) +
                                    " has no bounds to sample; take a box");
      },
      []() -> Vec3 {
        throw std::invalid_argument("a grid is sampled already; sample what it was made from");
      });
}

}  // namespace

FieldPoint signed_distance(const Shape& shape, Side side, const Vec3& position) noexcept {
  FieldPoint point = of_solid(shape, position);
  if (side == Side::inside) {
    point.distance = -point.distance;
    point.gradient = -point.gradient;
  }
  return point;
}

double distance_at_least(const Shape& shape, Side side, const Vec3& position,
                         double wanted) noexcept {
  const double sign = side == Side::outside ? 1.0 : -1.0;
  if (const auto* grid = std::get_if<Grid>(&shape))
    return grid->field->at_least(position, sign, wanted);
  return sign * of_solid(shape, position).distance;
}

void signed_distance(const Shape& shape, Side side, FieldGroup& group) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape))
    grid->field->at(group);
  else
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
      group.put(lane, of_solid(shape, group.place(lane)));
  if (side == Side::outside) return;
  group.distance = -group.distance;
  group.gradient_x = -group.gradient_x;
  group.gradient_y = -group.gradient_y;
  group.gradient_z = -group.gradient_z;
}

void distance_at_least(const Shape& shape, Side side, FieldGroup& group,
                       const FieldGroup::Lanes& wanted) noexcept {
  const double sign = side == Side::outside ? 1.0 : -1.0;
  if (const auto* grid = std::get_if<Grid>(&shape))
    return grid->field->at_least(group, sign, wanted);
  for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
    group.distance[static_cast<Eigen::Index>(lane)] =
        sign * of_solid(shape, group.place(lane)).distance;
}

Solid solid_of(const Shape& shape) {
  const Vec3 half = half_box(shape);
  return {-half, half, [shape](const Vec3& p) { return of_solid(shape, p).distance; }};
}

}  // namespace feltwire

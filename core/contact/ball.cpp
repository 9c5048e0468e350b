#include "core/contact/ball.hpp"

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_contact.hpp"

namespace feltwire {
namespace {

/// One formula on both sides of the surface: the potential is (radius - d)^2.
SurfacePoint sampled(const Grid& grid, Side side, const Vec3& p, double radius,
                     FeatureMemory& memory) {
  const FieldPoint field = signed_distance(grid, side, p);
  const Polar<double> out = polar(field.gradient);
  if (!(field.distance < radius) || !(out.length > 0.0)) {
    memory = {};
    return {};
  }
  memory.feature = 1;
  memory.normal = out.direction;
  return {p - field.distance * out.direction, out.direction,
          (radius - field.distance) * out.length};
}

}  // namespace

SurfacePoint ball_surface(const Shape& shape, Side side, const Vec3& p, double radius,
                          FeatureMemory& memory) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape)) return sampled(*grid, side, p, radius, memory);
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    return mesh_surface_point(*mesh->surface, side, p, memory, radius);
  return on_primitive(
      shape, [&](const auto& solid) { return solid.ball_surface(side, p, radius, memory); },
      [&] {
        memory = {};
        return SurfacePoint{};
      });
}

bool ball_fits(const Shape& shape, Side side, double radius) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape)) return radius <= grid->field->band();
  if (side == Side::outside) return true;
  return on_primitive(
      shape, [&](const auto& solid) { return radius < solid.room(); }, [] { return true; });
}

}  // namespace feltwire

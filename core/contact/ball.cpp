#include "core/contact/ball.hpp"

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_contact.hpp"

namespace feltwire {
namespace {

/// Computes the contact of a ball with a grid. The formula is the same on both sides of the
/// surface: the potential is (radius - d)^2, where d is the signed distance of the centre.
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
  const double beneath = radius - field.distance;
  return {p + beneath * out.direction, out.direction, beneath * out.length};
}

/// Computes the contact of a ball with the outside of a solid. The contact surface has rounded
/// edges, because the ball has a radius. While the centre of the ball is outside the solid, the
/// function uses the signed distance. While the centre is inside, it uses the solid's
/// surface_point().
template <Primitive Solid>
SurfacePoint rounded(const Solid& solid, const Vec3& p, double radius, FeatureMemory& memory) {
  SurfacePoint centre = solid.surface_point(Side::outside, p, memory);
  if (centre.depth > 0.0) {
    centre.depth += radius;
    centre.point += radius * centre.normal;
    return centre;
  }
  const FieldPoint field = solid.signed_distance(p);
  const Polar<double> out = polar(field.gradient);
  if (!(field.distance < radius) || !(out.length > 0.0)) return {};
  memory.normal = out.direction;
  const double depth = radius - field.distance;
  return {p + depth * out.direction, out.direction, depth};
}

template <Primitive Solid>
SurfacePoint met_by(const Grown<Solid>& grown, Side side, const Vec3& p, FeatureMemory& memory) {
  if (grown.round > 0.0) return rounded(grown.solid, p, grown.round, memory);
  SurfacePoint centre = grown.solid.surface_point(side, p - grown.middle, memory);
  if (centre.depth > 0.0) centre.point += grown.middle;
  return centre;
}

}  // namespace

SurfacePoint ball_surface(const Shape& shape, Side side, const Vec3& p, double radius,
                          FeatureMemory& memory, WorkLimit* work) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape)) return sampled(*grid, side, p, radius, memory);
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    return mesh_surface_point(*mesh->surface, side, p, memory, radius, work);
  return on_primitive(
      shape, [&](const auto& solid) { return met_by(solid.grown(side, radius), side, p, memory); },
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

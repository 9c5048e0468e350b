#include "core/contact/ball.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_contact.hpp"

namespace feltwire {
namespace {

/// Moves the proxy of the ball's centre back by the radius, to the point where the ball touches the
/// surface.
SurfacePoint under(SurfacePoint centre, double radius) {
  if (centre.depth > 0.0) centre.point -= radius * centre.normal;
  return centre;
}

/// The same for a round solid. The centre may have been pushed past the middle, so that the
/// surface's normal there is not that of the side which the ball touches: use the remembered
/// normal.
SurfacePoint under_round(SurfacePoint centre, double radius, const FeatureMemory& memory,
                         bool outside) {
  if (!outside) return under(centre, radius);
  if (centre.depth > 0.0) centre.point -= radius * memory.normal;
  return centre;
}

/// Uses the signed distance while the centre is outside the solid, and the solid's own proxy while
/// it is inside.
SurfacePoint rounded(const Shape& shape, Side side, const Vec3& p, double radius,
                     FeatureMemory& memory) {
  const SurfacePoint inside = surface_point(shape, side, p, memory);
  if (inside.depth > 0.0) return {inside.point, inside.normal, inside.depth + radius};
  const FieldPoint field = signed_distance(shape, side, p);
  const Polar<double> out = polar(field.gradient);
  if (!(field.distance < radius) || !(out.length > 0.0)) return {};
  memory.normal = out.direction;
  return {p - field.distance * out.direction, out.direction, radius - field.distance};
}

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
  const bool outside = side == Side::outside;
  const double grown = outside ? radius : -radius;
  if (std::holds_alternative<Plane>(shape))
    return under(surface_point(shape, side, p - grown * Vec3::UnitZ(), memory), 0.0);
  if (const auto* s = std::get_if<Sphere>(&shape))
    return under_round(surface_point(Sphere{s->radius + grown}, side, p, memory), radius, memory,
                       outside);
  if (const auto* c = std::get_if<Capsule>(&shape))
    return under_round(surface_point(Capsule{c->radius + grown, c->half_length}, side, p, memory),
                       radius, memory, outside);
  if (const auto* grid = std::get_if<Grid>(&shape)) return sampled(*grid, side, p, radius, memory);
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    return mesh_surface_point(*mesh->surface, side, p, memory, radius);
  if (outside) return rounded(shape, side, p, radius, memory);
  if (const auto* b = std::get_if<Box>(&shape))
    return under(surface_point(Box{b->half_extents - Vec3::Constant(radius)}, side, p, memory),
                 radius);
  if (const auto* c = std::get_if<Cylinder>(&shape))
    return under(
        surface_point(Cylinder{c->radius - radius, c->half_length - radius}, side, p, memory),
        radius);
  memory = {};
  return {};
}

bool ball_fits(const Shape& shape, Side side, double radius) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape)) return radius <= grid->field->band();
  if (side == Side::outside) return true;
  if (const auto* s = std::get_if<Sphere>(&shape)) return radius < s->radius;
  if (const auto* c = std::get_if<Capsule>(&shape)) return radius < c->radius;
  if (const auto* b = std::get_if<Box>(&shape)) return radius < b->half_extents.minCoeff();
  if (const auto* c = std::get_if<Cylinder>(&shape))
    return radius < std::min(c->radius, c->half_length);
  return true;
}

}  // namespace feltwire

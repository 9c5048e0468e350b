#include "core/contact/surface_point.hpp"

#include "core/base/numeric.hpp"
#include "core/grid/distance_grid.hpp"
#include "core/mesh/mesh_contact.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {
namespace {

SurfacePoint surface(const Grid& grid, Side side, const Vec3& p, FeatureMemory& memory) {
  const FieldPoint field = grid.field->at(p);
  const double below = side == Side::outside ? -field.distance : field.distance;
  if (!(below > 0.0)) {
    memory = {};
    return {};
  }
  memory.feature = 1;
  const Polar<double> out = polar(field.gradient);
  if (!(out.length > 0.0)) return {p, memory.normal, 0.0};
  memory.normal = side == Side::outside ? out.direction : Vec3(-out.direction);
  const double depth = below * out.length;
  return {p + depth * memory.normal, memory.normal, depth};
}

}  // namespace

SurfacePoint surface_point(const Shape& shape, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept {
  // get_if instead of visit: visit may throw, and this is the servo loop.
  if (const auto* plane = std::get_if<Plane>(&shape))
    return surface_point(*plane, side, position, memory);
  if (const auto* sphere = std::get_if<Sphere>(&shape))
    return surface_point(*sphere, side, position, memory);
  if (const auto* box = std::get_if<Box>(&shape))
    return surface_point(*box, side, position, memory);
  if (const auto* capsule = std::get_if<Capsule>(&shape))
    return surface_point(*capsule, side, position, memory);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape))
    return surface_point(*cylinder, side, position, memory);
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    return mesh_surface_point(*mesh->surface, side, position, memory);
  if (const auto* grid = std::get_if<Grid>(&shape)) return surface(*grid, side, position, memory);
  memory = {};
  return {};
}

bool follows_way(const Shape& shape, Side side) noexcept {
  if (std::holds_alternative<Mesh>(shape)) return true;
  return side == Side::outside && !std::holds_alternative<Plane>(shape) &&
         !std::holds_alternative<Grid>(shape);
}

Vec3 origin_of(const Shape& shape) noexcept {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh != nullptr ? mesh->surface->mesh().origin() : Vec3(Vec3::Zero());
}

void approach_from(const Shape& shape, const Vec3& position, FeatureMemory& memory) noexcept {
  memory = {};
  memory.proxy = position - origin_of(shape);
  memory.tracked = true;
}

}  // namespace feltwire

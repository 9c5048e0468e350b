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
                           FeatureMemory& memory, WorkLimit* work) noexcept {
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    return mesh_surface_point(*mesh->surface, side, position, memory, 0.0, work);
  if (const auto* grid = std::get_if<Grid>(&shape)) return surface(*grid, side, position, memory);
  return on_primitive(
      shape, [&](const auto& solid) { return solid.surface_point(side, position, memory); },
      [&] {
        memory = {};
        return SurfacePoint{};
      });
}

bool follows_way(const Shape& shape, Side side) noexcept {
  if (std::holds_alternative<Mesh>(shape)) return true;
  return side == Side::outside &&
         on_primitive(
             shape, [](const auto& solid) { return is_bounded(solid); }, [] { return false; });
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

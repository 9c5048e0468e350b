#include "server/web/object_triangles.hpp"

#include <variant>

#include "core/grid/isosurface.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire::web {
namespace {

constexpr int kSegments = 32;       // number of segments around a round shape
constexpr int kPlaceSegments = 16;  // the number for a guide's shape, which is sent as text
constexpr int kGridSteps = 64;      // number of steps along the longest side of a grid

}  // namespace

TriangleSoup plane_square() {
  constexpr double kHalf = kPlaneView;
  return {{{-kHalf, -kHalf, 0.0}, {kHalf, -kHalf, 0.0}, {kHalf, kHalf, 0.0}, {-kHalf, kHalf, 0.0}},
          {{0, 1, 2}, {0, 2, 3}}};
}

Pose square_pose(const Pose& plane, const Vec3& start) {
  const Vec3 normal = plane.orientation * Vec3::UnitZ();
  return {start - normal * normal.dot(start - plane.position), plane.orientation};
}

TriangleSoup triangles_of_place(const GuidePlace& place) {
  if (std::holds_alternative<Plane>(place)) return plane_square();
  return on_primitive(
      place, [](const auto& solid) { return solid.triangles(kPlaceSegments); },
      [] { return TriangleSoup{}; });
}

TriangleSoup triangles_of(const Shape& shape) {
  if (const auto* mesh = std::get_if<Mesh>(&shape)) {
    const TriangleMesh& surface = mesh->surface->mesh();
    TriangleSoup soup{surface.vertices(), surface.triangles()};
    for (Vec3& vertex : soup.vertices) vertex += surface.origin();
    return soup;
  }
  if (const auto* grid = std::get_if<Grid>(&shape)) return isosurface(*grid->field, kGridSteps);
  return on_primitive(
      shape, [](const auto& primitive) { return primitive.triangles(kSegments); },
      [] { return TriangleSoup{}; });
}

}  // namespace feltwire::web

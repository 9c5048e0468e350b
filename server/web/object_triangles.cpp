#include "server/web/object_triangles.hpp"

#include <variant>

#include "core/grid/isosurface.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire::web {
namespace {

constexpr int kSegments = 32;   // of a round side
constexpr int kGridSteps = 64;  // along a grid's longest side

}  // namespace

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

#include "core/mesh/mesh_distance.hpp"

#include <limits>
#include <stdexcept>
#include <string>
#include <utility>

namespace feltwire {
namespace {

void require_solid(const MeshReport& report) {
  const auto refuse = [](const std::string& what) { throw std::invalid_argument("mesh: " + what); };
  const auto edges = [](std::size_t n) {
    return std::to_string(n) + (n == 1 ? " edge" : " edges");
  };
  if (report.boundary_edges > 0)
    refuse("is open at " + edges(report.boundary_edges) +
           ", so that nothing is inside; close the holes");
  if (report.non_manifold_edges > 0)
    refuse("has more than two triangles at " + edges(report.non_manifold_edges) +
           ", so that inside and outside are not told apart; take its solids apart");
  if (report.turned_edges > 0)
    refuse("has triangles that disagree about the outside at " + edges(report.turned_edges) +
           "; orient them alike");
  if (!(report.volume > 0.0))
    refuse("is inside out: it encloses a negative volume; turn its triangles round");
}

}  // namespace

Solid solid_of(std::shared_ptr<const MeshSurface> surface) {
  const TriangleMesh& mesh = surface->mesh();
  require_solid(mesh.report());
  return {mesh.origin() - mesh.half_extents(), mesh.origin() + mesh.half_extents(),
          [surface = std::move(surface)](const Vec3& position) {
            const Vec3 p = position - surface->mesh().origin();
            const auto nearest = surface->nearest(p, std::numeric_limits<double>::infinity());
            return surface->side_of(p, nearest) < 0.0 ? -nearest.distance : nearest.distance;
          }};
}

Solid solid_of(TriangleMesh mesh) {
  require_solid(mesh.report());
  return solid_of(std::make_shared<const MeshSurface>(std::move(mesh)));
}

double grid_resolution(const TriangleMesh& mesh) {
  return 2.0 * mesh.half_extents().maxCoeff() / kMeshGridSteps;
}

Grid grid_for_body(std::shared_ptr<const MeshSurface> surface, std::size_t max_bytes) {
  const GridOptions options{.resolution = grid_resolution(surface->mesh()), .max_bytes = max_bytes};
  return {std::make_shared<const DistanceGrid<float>>(solid_of(std::move(surface)), options)};
}

}  // namespace feltwire

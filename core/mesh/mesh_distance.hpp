#pragma once
// Signed distance to a closed surface of triangles.

#include <memory>

#include "core/geometry/shapes.hpp"
#include "core/grid/distance_grid.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// The solid that a closed mesh bounds, to be sampled. Its distance is that to the nearest triangle
/// (MeshSurface::nearest). Its sign (MeshSurface::side_of) is exact where the surface does not cut
/// itself. Where it does, the sign is that of the nearest sheet. Throws std::invalid_argument if
/// the mesh is open, has edges of more than two triangles, is oriented both ways or inside out.
Solid solid_of(std::shared_ptr<const MeshSurface> surface);
/// As above, with a tree of its own. Throws std::runtime_error too, if there is no memory for it.
Solid solid_of(TriangleMesh mesh);

/// [m] The resolution of the grid that a tool with a body touches in place of a mesh: so many steps
/// along the mesh's longest side.
inline constexpr double kMeshGridSteps = 128.0;
double grid_resolution(const TriangleMesh& mesh);
/// That grid. Throws as solid_of(), and as the grid itself: GridTooLarge beyond `max_bytes`.
Grid grid_for_body(std::shared_ptr<const MeshSurface> surface,
                   std::size_t max_bytes = GridOptions{}.max_bytes);

}  // namespace feltwire

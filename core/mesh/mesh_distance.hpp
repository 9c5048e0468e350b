#pragma once
// Signed distance to a closed surface of triangles.

#include <memory>

#include "core/grid/distance_grid.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

/// The solid that a closed mesh bounds, to be sampled. Its distance is that to the nearest triangle
/// (MeshSurface::nearest). Its sign (MeshSurface::side_of) is exact where the surface does not cut
/// itself. Where it does, the sign is that of the nearest sheet. Throws std::invalid_argument if
/// the mesh is open, has edges of more than two triangles, is oriented both ways or inside out.
Solid solid_of(std::shared_ptr<const MeshSurface> surface);
/// The same with a tree of its own. Throws std::runtime_error too, if there is no memory for it.
Solid solid_of(TriangleMesh mesh);

}  // namespace feltwire

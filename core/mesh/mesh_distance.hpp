#pragma once
// Signed distance to a closed surface of triangles.

#include <memory>

#include "core/grid/distance_grid.hpp"
#include "core/mesh/triangle_mesh.hpp"

namespace feltwire {

/// The solid that a closed mesh bounds, to be sampled. Distance: nearest triangle by Embree's tree,
/// decided in double. Sign: angle-weighted pseudo-normals of the nearest face, edge or corner
/// (Baerentzen & Aanaes, Signed distance computation using the angle weighted pseudonormal, TVCG
/// 2005), which is exact for a closed surface that does not cut itself; where it does, the sign is
/// that of the nearest sheet. A million queries a second and core. The mesh is copied.
///
/// Throws std::invalid_argument when the mesh is open, has edges of more than two triangles, is
/// oriented both ways or inside out.
Solid solid_of(const TriangleMesh& mesh);

/// The same as a field: distance, and the way out from the nearest point of the mesh.
struct MeshField {
  std::function<FieldPoint(const Vec3&)> at;
  std::size_t bytes = 0;  // that it holds, the tree's included
};
MeshField field_of(const TriangleMesh& mesh);

}  // namespace feltwire

#pragma once
// Approximate convex decomposition: a closed mesh as a few convex solids that cover it.

#include <cstddef>
#include <cstdint>
#include <optional>
#include <vector>

#include "core/convex/convex_hull.hpp"
#include "core/mesh/mesh_surface.hpp"

namespace feltwire {

struct DecompositionOptions {
  /// [m] No part reaches farther out of the solid. Nothing: kPartTolerance of the longest side.
  std::optional<double> tolerance{};
  std::size_t most = 64;  // parts; 1: the hull of the whole
};
inline constexpr double kPartTolerance = 0.02;
/// Of the longest side. The time grows with the square of what is left of it.
inline constexpr double kLeastPartTolerance = 0.001;
inline constexpr std::size_t kMostParts = 1024;
/// Raise it with every change of the parts that a mesh gets: parts that were kept are then made
/// anew.
inline constexpr std::uint32_t kDecompositionVersion = 1;

/// Convex solids that cover a mesh. Coordinates are relative to the mesh's origin.
struct ConvexParts {
  std::vector<std::vector<Vec3>> parts;  // [m] the corners of each, at least four
  double tolerance = 0.0;                // [m] that was asked for
  /// [m] The largest distance of a point of a part from the mesh's solid that was found. It is at
  /// most the tolerance, unless `most` parts were too few.
  double outside = 0.0;
};

/// [m]
double tolerance_of(const DecompositionOptions& options, const TriangleMesh& mesh);

/// Cuts a solid by planes until the hull of each piece reaches out of it by no more than the
/// tolerance, then joins neighbours as long as that holds. The next piece is the one whose hull
/// reaches out farthest; its plane is the one that leaves the hulls with the least volume, among
/// even places along the axes and the faces at its hollow edges (after Mamou & Ghorbel 2009; Wei et
/// al. 2022, Approximate convex decomposition for 3D meshes with collision-aware concavity). So the
/// parts cover all of the solid. The same mesh and options give the same bits, on any number of
/// cores. Precondition: the surface is closed with its normals outwards; tolerance > 0; 1 <= most
/// <= kMostParts. Works on all cores; throws Cancelled, std::bad_alloc, and std::runtime_error if
/// Qhull gives up.
ConvexParts convex_parts(const MeshSurface& solid, const DecompositionOptions& options);

}  // namespace feltwire

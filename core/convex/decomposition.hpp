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
  /// [m] The largest allowed distance of a part out of the solid. Empty: kPartTolerance of the
  /// longest side.
  std::optional<double> tolerance{};
  std::size_t most = 64;  // number of parts; 1: the hull of the whole
};
inline constexpr double kPartTolerance = 0.02;
/// Share of the longest side. The time grows with the inverse square of it.
inline constexpr double kLeastPartTolerance = 0.001;
inline constexpr std::size_t kMostParts = 1024;
/// Increase it with every change of the result: kept parts are then computed again.
inline constexpr std::uint32_t kDecompositionVersion = 2;

/// Convex solids that cover a mesh. Coordinates are relative to the mesh's origin.
struct ConvexParts {
  std::vector<std::vector<Vec3>> parts;  // [m] the corners of each, at least four
  double tolerance = 0.0;                // [m] the requested one
  /// [m] The largest distance found of a point of a part from the mesh's solid. It is at most the
  /// tolerance, unless `most` parts were too few.
  double outside = 0.0;
};

/// [m]
double tolerance_of(const DecompositionOptions& options, const TriangleMesh& mesh);

/// Cuts a solid by planes until the hull of each piece reaches out of it by at most the tolerance,
/// then joins neighbours as long as that holds. The next piece is the one whose hull reaches out
/// farthest. Its plane is the one with the least volume of the two hulls, among evenly spaced
/// places along the axes and the faces at its hollow edges (after Mamou & Ghorbel 2009; Wei et al.
/// 2022, Approximate convex decomposition for 3D meshes with collision-aware concavity). So the
/// parts cover all of the solid. The same mesh and options give the same bits, on any number of
/// cores. Precondition: the surface is closed with its normals outwards; tolerance > 0; 1 <= most
/// <= kMostParts. Works on all cores; throws Cancelled, std::bad_alloc, and std::runtime_error if
/// Qhull fails.
ConvexParts convex_parts(const MeshSurface& solid, const DecompositionOptions& options);

}  // namespace feltwire

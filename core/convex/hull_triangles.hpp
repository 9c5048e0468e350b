#pragma once
// The triangles of a convex hull.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/convex/convex_hull.hpp"

namespace feltwire {

struct HullTriangles {
  /// Indices of ConvexHull::vertices, counter-clockwise seen from outside. Every edge is that of
  /// two triangles.
  std::vector<std::array<std::uint32_t, 3>> corners;
  std::vector<HalfSpaceBelow> planes;  // of each triangle; those of one face have equal numbers
};

/// Returns the triangles of convex_hull(points), as Qhull joins them: they close also where
/// rounding makes corners nearly coplanar. Empty if the points lie in one plane. Precondition and
/// errors as of convex_hull().
HullTriangles hull_triangles(std::span<const Vec3> points);

}  // namespace feltwire

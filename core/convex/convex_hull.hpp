#pragma once
// The convex hull of points, by Qhull.

#include <optional>
#include <span>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// The points x with normal . x <= offset.
struct HalfSpaceBelow {
  Vec3 normal = Vec3::UnitZ();  // unit
  double offset = 0.0;          // [m]
};

/// A convex polyhedron.
struct ConvexHull {
  std::vector<Vec3> vertices;  // [m] the corners, in the order of the points given
  std::vector<HalfSpaceBelow>
      planes;  // of its faces; the plane of a face with many corners may occur more than once
  double volume = 0.0;  // [m^3]

  bool contains(const Vec3& p, double slack = 0.0) const noexcept {
    for (const HalfSpaceBelow& plane : planes)
      if (plane.normal.dot(p) > plane.offset + slack) return false;
    return true;
  }
};

/// Returns the hull of points. Its corners are given points, to the bit (Barber, Dobkin & Huhdanpaa
/// 1996, The Quickhull algorithm for convex hulls). Empty if the points lie in one plane, to
/// rounding, so that there is no volume. The same points in the same order give the same bits.
/// Precondition: the points are finite. Throws std::runtime_error if Qhull fails, and
/// std::bad_alloc.
std::optional<ConvexHull> convex_hull(std::span<const Vec3> points);

}  // namespace feltwire

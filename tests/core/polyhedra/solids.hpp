#pragma once
// Solids for tests of polyhedra and of polygonal tools.

#include <vector>

#include "core/polyhedra/clipped_polyhedron.hpp"
#include "core/polyhedra/solid_parts.hpp"
#include "tests/core/support.hpp"

namespace feltwire::test {

/// The corners of a box, from its half extents and its middle [m].
inline std::vector<Vec3> box_corners(const Vec3& half, const Vec3& at = Vec3::Zero()) {
  std::vector<Vec3> corners;
  for (int i = 0; i < 8; ++i)
    corners.push_back(at + Vec3((i & 1) != 0 ? half.x() : -half.x(),
                                (i & 2) != 0 ? half.y() : -half.y(),
                                (i & 4) != 0 ? half.z() : -half.z()));
  return corners;
}

/// The hull of `corners` random points, at 0.7 to 1 times `size` [m] from the origin.
inline Polyhedron random_solid(Random& random, double size, int corners = 20) {
  std::vector<Vec3> points;
  for (int i = 0; i < corners; ++i)
    points.push_back(size * random.uniform(0.7, 1.0) * random.direction());
  return polyhedron(points);
}

/// A solid with a single part; all its faces are felt.
inline SolidParts one_part(const Polyhedron& shape) {
  SolidParts solid;
  solid.parts.resize(1);
  solid.parts[0].shape = shape;
  solid.parts[0].inner.assign(shape.planes.size(), 0);
  return solid;
}

inline ClippedPolyhedron placed(const Polyhedron& solid) {
  ClippedPolyhedron whole;
  whole.assign(solid, Mat3::Identity(), Vec3::Zero());
  return whole;
}

}  // namespace feltwire::test

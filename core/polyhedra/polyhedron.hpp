#pragma once
// A convex polyhedron with its faces as polygons.

#include <cstdint>
#include <span>
#include <vector>

#include "core/base/types.hpp"
#include "core/convex/convex_hull.hpp"
#include "core/polyhedra/corner_graph.hpp"

namespace feltwire {

/// Two faces meet in it. Seen from outside it runs counter-clockwise round `left`.
struct PolyhedronEdge {
  std::uint32_t from = 0, to = 0;     // vertices
  std::uint32_t left = 0, right = 0;  // faces
};

/// Bounded, with volume. Coplanar triangles are one face, so that a box has six.
struct Polyhedron {
  std::vector<Vec3> vertices;          // [m]
  std::vector<HalfSpaceBelow> planes;  // of the faces, normals outwards
  std::vector<std::uint32_t> first;    // face f has loop[first[f]] ... loop[first[f + 1] - 1]
  std::vector<std::uint32_t> loop;     // vertices, counter-clockwise seen from outside
  std::vector<PolyhedronEdge> edges;
  std::vector<GraphCorner> graph;                  // of the surface
  Vec3 centre = Vec3::Zero();                      // [m] of a ball that holds all vertices
  double radius = 0.0;                             // [m]
  Vec3 least = Vec3::Zero(), most = Vec3::Zero();  // [m] the box along the axes

  std::span<const std::uint32_t> face(std::size_t f) const {
    return std::span(loop).subspan(first[f], first[f + 1] - first[f]);
  }
};

/// Largest number of vertices: what a query may copy to the stack.
inline constexpr std::size_t kMostPolyhedronVertices = 512;

/// The convex hull of points as a polyhedron. Faces whose planes agree to kCoplanar of the size are
/// one face. Throws std::invalid_argument with a remedy if the points have no volume, are more than
/// kMostPolyhedronVertices corners, or are so nearly coplanar that their faces do not close.
Polyhedron polyhedron(std::span<const Vec3> points);

inline constexpr double kCoplanar = 1e-9;

/// Corners of a convex solid whose hull leaves out at most `error` [m] of it: the extreme ones,
/// then the one that is farthest out as long as it is more. For parts that are not exact in any
/// case: the time of a contact grows with their faces. At most kMostFewCorners. Throws as
/// convex_hull() does.
std::vector<Vec3> fewer_corners(const std::vector<Vec3>& corners, double error);

inline constexpr std::size_t kMostFewCorners = 32;

}  // namespace feltwire

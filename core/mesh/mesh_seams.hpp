#pragma once
// Edges of a surface that have one triangle: joining them where they miss each other by rounding,
// and how wide the holes between them are.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::mesh_seams {

/// Two vertices.
using Edge = std::array<std::uint32_t, 2>;

/// For each vertex the one that takes its place.
struct Joined {
  std::vector<std::uint32_t> renamed;
  std::size_t count = 0;  // vertices that another one takes the place of
  double farthest = 0.0;  // [m] between the two
};

/// Joins ends of open edges that are at most `weld` [m] apart, the nearest first of those that
/// stand. No vertex goes farther than a quarter of the shortest side of its triangles, so that no
/// detail is lost, however far away another vertex lies.
Joined join(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
            std::span<const Edge> open, double weld);

struct Holes {
  std::size_t count = 0;
  double narrowest = 0.0, widest = 0.0;  // [m] the size of a ball that passes, about
};

/// Open edges form rings; each is a hole, or the border of a sheet. Its width: from places of the
/// ring to the nearest other that is 1.49 times as far away along the ring, three of four are at
/// most that.
Holes holes(std::span<const Vec3> vertices, std::span<const Edge> open);

}  // namespace feltwire::mesh_seams

#pragma once
// Open edges of a surface, which have one triangle only: joins those that miss each other by
// rounding, and measures the holes that remain.

#include <array>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::mesh_seams {

/// Two vertices.
using Edge = std::array<std::uint32_t, 2>;

struct Joined {
  std::vector<std::uint32_t> renamed;  // for each vertex, the one that replaces it
  std::size_t count = 0;               // vertices that another one replaces
  double farthest = 0.0;               // [m] largest distance between two that were joined
};

/// Joins ends of open edges that are at most `weld` [m] apart, the nearest pairs first. A vertex
/// moves by at most a quarter of the shortest side of its triangles, so no detail is lost, even if
/// `weld` is large.
Joined join(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
            std::span<const Edge> open, double weld);

/// Open edges form rings. Each ring is a hole, or the border of a sheet. Its width is the upper
/// quartile, over places of the ring, of the distance to the nearest place that is at least 1.49
/// times as far away along the ring.
MeshHoles holes(std::span<const Vec3> vertices, std::span<const Edge> open);

}  // namespace feltwire::mesh_seams

#pragma once
// Corners of one part of a surface in the middle of open edges of another part (T-junctions).

#include <cstddef>
#include <cstdint>
#include <span>
#include <vector>

#include "core/mesh/triangle_mesh.hpp"

namespace feltwire::edge_splits {

struct Split {
  std::vector<Triangle> triangles;  // all, with the parts of a triangle at its place
  std::size_t edges = 0;            // that were split
  double farthest = 0.0;            // [m] largest distance of such a corner from its edge
  bool all_looked = true;           // false: so many edges lie over each other that some were not
};

/// Splits the open edges that have ends of other open edges on them, at most `weld` [m] away, so
/// that they meet edge by edge. A triangle gets parts on its own corners and on these. An edge
/// moves by at most a quarter of its triangle's height and of the parts it is split into, so no
/// detail is lost, even if `weld` is large. An edge stays whole if none of its parts would meet
/// another. `open`: sides of triangles, 3 * triangle + number of the side. Of a triangle one side
/// is split at a time: call it again until it splits nothing.
Split split(std::span<const Vec3> vertices, std::span<const Triangle> triangles,
            std::span<const std::uint32_t> open, double weld);

}  // namespace feltwire::edge_splits

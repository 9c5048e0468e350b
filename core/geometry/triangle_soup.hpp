#pragma once

#include <array>
#include <cstdint>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// Indices of the corners, counter-clockwise seen from the outside.
using Triangle = std::array<std::uint32_t, 3>;

/// Vertices and triangles as given, without any check.
struct TriangleSoup {
  std::vector<Vec3> vertices;  // [m]
  std::vector<Triangle> triangles;
};

}  // namespace feltwire

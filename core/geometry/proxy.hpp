#pragma once
// The proxy of a point on a surface, and what it remembers.

#include <cstdint>

#include "core/base/types.hpp"

namespace feltwire {

/// Which side of the surface is free to move in.
enum class Side : std::uint8_t { outside, inside };

/// Where the (frictionless) proxy stands on the surface, object frame.
struct SurfacePoint {
  Vec3 point = Vec3::Zero();    // [m] on the surface
  Vec3 normal = Vec3::UnitZ();  // unit, towards the free side
  double depth = 0.0;           // [m] |position - point|, 0 when free
};

/// The proxy's memory of one shape between samples, so that it does not jump through a thin solid.
struct FeatureMemory {
  std::uint32_t feature = 0;    // 0: not in contact; else 1 + index of the face the proxy stands on
  Vec3 normal = Vec3::UnitZ();  // last one, of the surface at the proxy: what is used where the
                                // geometry leaves it undefined (a centre, an axis)
  // Of a mesh and a solid felt from outside: where the proxy was, free or not (on what is round,
  // where the tool was), so that the way to where the tool is now is followed, passing nothing by.
  Vec3 proxy = Vec3::Zero();   // [m, object frame, from origin_of() the shape]
  std::uint32_t triangle = 0;  // of a mesh: that it stands on; of a ring: its part, where
                               // that is not the part nearest to the tool (torus.cpp)
  std::int8_t side = 0;        // 0: the proxy is free. Of a mesh's triangle: 1 where its normal
                               // points, -1 behind. Of a solid: 1
  bool tracked = false;        // proxy is known
};

}  // namespace feltwire

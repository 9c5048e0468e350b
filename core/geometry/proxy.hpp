#pragma once
// The proxy of a point on a surface, and its memory between samples.

#include <cstdint>

#include "core/base/types.hpp"

namespace feltwire {

/// The side of the surface where the tool is free.
enum class Side : std::uint8_t { outside, inside };

/// The position of the (frictionless) proxy on the surface, object frame.
struct SurfacePoint {
  Vec3 point = Vec3::Zero();    // [m] on the surface
  Vec3 normal = Vec3::UnitZ();  // unit, towards the free side
  double depth = 0.0;           // [m] |position - point|, 0 when free
};

/// The proxy's memory of one shape between samples, so that it does not jump through a thin solid.
struct FeatureMemory {
  std::uint32_t feature = 0;    // 0: not in contact; else 1 + index of the proxy's face
  Vec3 normal = Vec3::UnitZ();  // the last normal of the surface at the proxy, used if the geometry
                                // leaves it undefined (a centre, an axis)
  // For a mesh and a solid felt from outside: the last place of the proxy, also in free motion (on
  // round surfaces the place of the tool). From it the proxy follows the tool's path and passes no
  // surface.
  Vec3 proxy = Vec3::Zero();   // [m, object frame, from origin_of() the shape]
  std::uint32_t triangle = 0;  // of a mesh: the proxy's triangle; of a ring: its part, if it is not
                               // the part nearest to the tool (torus.cpp)
  std::int8_t side = 0;  // 0: the proxy is free. Of a mesh's triangle: 1 on the side of its normal,
                         // -1 behind. Of a solid: 1
  bool tracked = false;  // proxy is known
};

}  // namespace feltwire

#pragma once
// What the proxies of all solids do with their memory.

#include <cstdint>

#include "core/geometry/proxy.hpp"

namespace feltwire {

// Every test for contact is written so that a NaN is free.

inline SurfacePoint no_contact(FeatureMemory& memory) {
  memory = {};
  return {};
}

inline SurfacePoint stand_on(const Vec3& point, const Vec3& normal, double depth, int feature,
                             FeatureMemory& memory) {
  memory.feature = static_cast<std::uint32_t>(1 + feature);
  memory.normal = normal;
  return {point, normal, depth};
}

/// Free of a solid that has a far side: where it is now is where it comes from next.
inline SurfacePoint free_at(const Vec3& p, FeatureMemory& memory) {
  memory = {};
  memory.proxy = p;
  memory.tracked = true;
  return {};
}

/// On such a solid.
inline SurfacePoint held_on(const SurfacePoint& on, int feature, FeatureMemory& memory) {
  memory.side = 1;
  memory.proxy = on.point;
  memory.tracked = true;
  return stand_on(on.point, on.normal, on.depth, feature, memory);
}

/// Who is farther `off` a solid than the way that he came cannot have been in it.
inline bool cannot_have_met(double off, const Vec3& way) {
  return off > 0.0 && way.squaredNorm() < off * off;
}

}  // namespace feltwire

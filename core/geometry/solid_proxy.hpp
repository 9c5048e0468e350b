#pragma once
// The use of the memory by the proxies of all solids.

#include <cstdint>

#include "core/geometry/proxy.hpp"

namespace feltwire {

// Every test for contact is written so that NaN counts as free.

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

/// The point is free of a solid with a far side. The next sample starts its path here.
inline SurfacePoint free_at(const Vec3& p, FeatureMemory& memory) {
  memory = {};
  memory.proxy = p;
  memory.tracked = true;
  return {};
}

/// The proxy is on such a solid.
inline SurfacePoint held_on(const SurfacePoint& on, int feature, FeatureMemory& memory) {
  memory.side = 1;
  memory.proxy = on.point;
  memory.tracked = true;
  return stand_on(on.point, on.normal, on.depth, feature, memory);
}

/// Whether a point that is `off` [m] outside a solid, after a movement of `way` [m], cannot have
/// been inside it meanwhile: it moved less than the distance.
inline bool cannot_have_met(double off, const Vec3& way) {
  return off > 0.0 && way.squaredNorm() < off * off;
}

}  // namespace feltwire

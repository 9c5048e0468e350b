#include <algorithm>

#include "core/geometry/round_proxy.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

SurfacePoint surface_point(const Capsule& capsule, Side side, const Vec3& p,
                           FeatureMemory& memory) noexcept {
  const double h = capsule.half_length;
  if (side == Side::inside)
    return hollow_surface(p, Vec3(0.0, 0.0, std::clamp(p.z(), -h, h)), capsule.radius, memory);
  // On the axis every direction across it is as near; beyond its ends so is the half sphere.
  Vec3 undefined = memory.normal;
  undefined.z() = std::clamp(undefined.z(), p.z() <= -h ? -1.0 : 0.0, p.z() >= h ? 1.0 : 0.0);
  undefined = undefined.isZero(0.0) ? Vec3::UnitX() : direction(undefined);
  return round_from_outside({capsule.radius, h}, p, undefined, memory);
}

}  // namespace feltwire

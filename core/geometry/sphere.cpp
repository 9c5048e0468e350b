#include "core/geometry/round_proxy.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

SurfacePoint surface_point(const Sphere& sphere, Side side, const Vec3& p,
                           FeatureMemory& memory) noexcept {
  if (side == Side::inside) return hollow_surface(p, Vec3::Zero(), sphere.radius, memory);
  return round_from_outside({sphere.radius, 0.0}, p, memory.normal, memory);
}

}  // namespace feltwire

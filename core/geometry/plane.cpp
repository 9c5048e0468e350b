#include "core/geometry/solid_proxy.hpp"

namespace feltwire {

SurfacePoint surface_point(const Plane&, Side side, const Vec3& p, FeatureMemory& memory) noexcept {
  const double up = side == Side::outside ? 1.0 : -1.0;
  if (!(up * p.z() < 0.0)) return no_contact(memory);
  return stand_on(Vec3(p.x(), p.y(), 0.0), Vec3(0.0, 0.0, up), -up * p.z(), 0, memory);
}

}  // namespace feltwire

#include "core/material/contact_law.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"

namespace feltwire {

// Returns the stretch of the friction spring. This spring and the surface have the same stiffness.
// So the friction cone |F_t| <= mu F_n also limits the length, without the stiffness: |stretch| <=
// mu * depth.
Vec3 stick_stretch(const Material& material, const SurfacePoint& surface,
                   ContactMemory& memory) noexcept {
  if (!memory.touching) {
    memory.anchor = surface.point;
    memory.slipping = false;
    return Vec3::Zero();
  }
  // On a curved surface, only the part of the stretch in the tangent plane at the proxy is
  // friction. The contact force already contains the rest.
  const Vec3 chord = memory.anchor - surface.point;
  Vec3 stretch = chord - along(chord, surface.normal);
  const double stretched = length(stretch);

  const double mu = memory.slipping ? material.dynamic_friction : material.static_friction;
  memory.slipping = stretched > mu * surface.depth;
  if (memory.slipping) {
    // When slipping begins, the force falls from mu_s F_n to mu_d F_n, and the anchor moves towards
    // the proxy.
    stretch *= material.dynamic_friction * surface.depth / stretched;
    memory.anchor = surface.point + stretch;
  }
  return stretch;
}

Vec3 carried(const Vec3& anchor, const Vec3& about, const Vec3& from, const Vec3& to) noexcept {
  const double cosine = from.dot(to);
  const Vec3 axis = from.cross(to), v = anchor - about;
  if (!(cosine > -0.5)) return anchor;  // After a turn of more than 120 degrees, the anchor stays.
  return about + cosine * v + axis.cross(v) + axis.dot(v) / (1.0 + cosine) * axis;
}

}  // namespace feltwire

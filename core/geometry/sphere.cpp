#include "core/geometry/sphere.hpp"

#include <numbers>

#include "core/geometry/revolution.hpp"
#include "core/geometry/round_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {

SurfacePoint Sphere::surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept {
  if (side == Side::inside) return hollow_surface(p, Vec3::Zero(), radius, memory);
  return round_from_outside({radius, 0.0}, p, memory.normal, memory);
}

Grown<Sphere> Sphere::grown(Side side, double ball) const noexcept {
  return {{radius + outward_sign(side) * ball}};
}

double Sphere::room() const noexcept { return radius; }

FieldPoint Sphere::signed_distance(const Vec3& p) const noexcept {
  return round_distance(Vec3::Zero(), radius, p, Vec3::UnitZ());
}

Vec3 Sphere::half_box() const noexcept { return Vec3::Constant(radius); }

double Sphere::reach() const noexcept { return radius; }

MassProperties Sphere::mass_properties() const {
  const double square = radius * radius;
  const double volume = 4.0 / 3.0 * std::numbers::pi * (radius * radius * radius);
  return {volume, Vec3::Zero(), 0.4 * volume * square * Mat3::Identity()};
}

TriangleSoup Sphere::triangles(int segments) const {
  return revolved(capsule_profile(radius, 0.0, segments), segments);
}

std::vector<PhysicsGeom> Sphere::geoms(Side side) const {
  if (side == Side::inside) return {};
  return {{.kind = PhysicsGeom::Kind::sphere, .size = {radius, 0.0, 0.0}}};
}

SurfaceParts Sphere::parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept {
  SurfaceParts all;
  const double near = std::max(0.0, height(side, p.norm(), radius));
  add(all, unless_entered(near, side, entered), kOnlyFeature);
  return all;
}

PatchGeometry Sphere::patch(Side side, const Vec3& p, int face, const FeatureMemory& memory,
                            bool touching) const noexcept {
  const Vec3 outward = or_else(direction(p), memory.normal);
  const Vec3* behind = left_behind(side, face, outward, memory, touching);
  return round_patch(side, Vec3::Zero(), behind != nullptr ? *behind : outward, radius);
}

}  // namespace feltwire

#include "core/geometry/plane.hpp"

#include "core/geometry/solid_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {

SurfacePoint Plane::surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept {
  const double up = side == Side::outside ? 1.0 : -1.0;
  if (!(up * p.z() < 0.0)) return no_contact(memory);
  return stand_on(Vec3(p.x(), p.y(), 0.0), Vec3(0.0, 0.0, up), -up * p.z(), 0, memory);
}

Grown<Plane> Plane::grown(Side side, double ball) const noexcept {
  return {*this, outward_sign(side) * ball * Vec3::UnitZ()};
}

double Plane::room() const noexcept { return std::numeric_limits<double>::infinity(); }

FieldPoint Plane::signed_distance(const Vec3& p) const noexcept { return {p.z(), Vec3::UnitZ()}; }

Vec3 Plane::half_box() const noexcept {
  return Vec3::Constant(std::numeric_limits<double>::infinity());
}

double Plane::reach() const noexcept { return std::numeric_limits<double>::infinity(); }

MassProperties Plane::mass_properties() const { return {}; }

TriangleSoup Plane::triangles(int) const { return {}; }

std::vector<PhysicsGeom> Plane::geoms(Side side) const {
  PhysicsGeom geom{.kind = PhysicsGeom::Kind::plane};
  if (side == Side::inside) geom.pose = {Vec3::Zero(), turn_to(Vec3::UnitZ(), -Vec3::UnitZ())};
  return {geom};
}

SurfaceParts Plane::parts(Side side, const Vec3& p, std::uint32_t) const noexcept {
  SurfaceParts all;
  add(all, std::max(0.0, side == Side::outside ? p.z() : -p.z()), kOnlyFeature);
  return all;
}

PatchGeometry Plane::patch(Side side, const Vec3& p, int, const FeatureMemory&,
                           bool) const noexcept {
  return {.point = {p.x(), p.y(), 0.0}, .normal = {0.0, 0.0, side == Side::outside ? 1.0 : -1.0}};
}

}  // namespace feltwire

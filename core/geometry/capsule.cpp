#include "core/geometry/capsule.hpp"

#include <algorithm>
#include <numbers>

#include "core/geometry/revolution.hpp"
#include "core/geometry/round_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {
namespace {

Vec3 on_axis(double half_length, const Vec3& p) {
  return {0.0, 0.0, std::clamp(p.z(), -half_length, half_length)};
}

}  // namespace

SurfacePoint Capsule::surface_point(Side side, const Vec3& p,
                                    FeatureMemory& memory) const noexcept {
  const double h = half_length;
  if (side == Side::inside) return hollow_surface(p, on_axis(h, p), radius, memory);
  // From a point on the axis, the surface is equally near in every direction across the axis. At
  // the ends of the axis, it is equally near in every direction of the half sphere. So use the
  // remembered normal.
  Vec3 undefined = memory.normal;
  undefined.z() = std::clamp(undefined.z(), p.z() <= -h ? -1.0 : 0.0, p.z() >= h ? 1.0 : 0.0);
  undefined = undefined.isZero(0.0) ? Vec3::UnitX() : direction(undefined);
  return round_from_outside({radius, h}, p, undefined, memory);
}

Grown<Capsule> Capsule::grown(Side side, double ball) const noexcept {
  return {{radius + outward_sign(side) * ball, half_length}};
}

double Capsule::room() const noexcept { return radius; }

FieldPoint Capsule::signed_distance(const Vec3& p) const noexcept {
  return round_distance(on_axis(half_length, p), radius, p, Vec3::UnitX());
}

Vec3 Capsule::half_box() const noexcept { return {radius, radius, half_length + radius}; }

double Capsule::reach() const noexcept { return radius + half_length; }

/// Returns the sum of a cylinder and two half balls. The centre of mass of a half ball is 3/8 r
/// beyond its flat face.
MassProperties Capsule::mass_properties() const {
  const double middle = 2.0 * std::numbers::pi * radius * radius * half_length;
  const double ends = 4.0 / 3.0 * std::numbers::pi * (radius * radius * radius);
  const double r = radius * radius, h = half_length;
  const double across =
      middle * (r / 4.0 + h * h / 3.0) + ends * (0.4 * r + h * h + 0.75 * radius * h);
  return {middle + ends, Vec3::Zero(), inertia_about_z(across, middle * r / 2.0 + ends * 0.4 * r)};
}

TriangleSoup Capsule::triangles(int segments) const {
  return revolved(capsule_profile(radius, half_length, segments), segments);
}

std::vector<PhysicsGeom> Capsule::geoms(Side side) const {
  if (side == Side::inside) return {};
  if (!(half_length > 0.0))
    return {{.kind = PhysicsGeom::Kind::sphere, .size = {radius, 0.0, 0.0}}};
  return {{.kind = PhysicsGeom::Kind::capsule, .size = {radius, half_length, 0.0}}};
}

/// Returns the parts of the surface near p. Side and ends form one smooth surface, but need more
/// than one patch. Only the patch nearest to p is modelled. The other patches begin behind their
/// junction with this patch.
SurfaceParts Capsule::parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept {
  SurfaceParts all;
  const double h = half_length;
  const double near = std::max(0.0, height(side, (p - on_axis(h, p)).norm(), radius));
  add(all, unless_entered(near, side, entered), kOnlyFeature);
  if (!(h > 0.0)) return all;
  // From outside, beside the cylinder, the shortest lines to the junction's plane and to the
  // surface are perpendicular, so Pythagoras gives the bound. From inside, only the longer of the
  // two lines is a safe bound.
  const double in = std::max(0.0, root(p.x(), p.y()) - radius);
  const auto behind = [&](double way) {
    add(all, side == Side::outside ? root(way, in) : std::max(way, near), kOnlyFeature, false);
  };
  if (std::abs(p.z()) <= h) {
    behind(h - p.z());
    behind(h + p.z());
  } else {
    behind(std::abs(p.z()) - h);
  }
  return all;
}

PatchGeometry Capsule::patch(Side side, const Vec3& p, int face, const FeatureMemory& memory,
                             bool touching) const noexcept {
  const double h = half_length;
  Vec3 core = on_axis(h, p);
  bool straight = h > 0.0 && std::abs(p.z()) <= h;
  Vec3 outward =
      straight ? across_axis(p, memory) : or_else(direction(Vec3(p - core)), memory.normal);
  if (const Vec3* behind = left_behind(side, face, outward, memory, touching)) {
    outward = *behind;
    core = RoundSolid{radius, h}.core_of(outward, p);
    straight = h > 0.0 && outward.z() == 0.0;
  }
  PatchGeometry s = round_patch(side, core, outward, radius);
  if (straight) s.axis = Vec3::UnitZ();
  return s;
}

}  // namespace feltwire

#include "core/geometry/cylinder.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/geometry/revolution.hpp"
#include "core/geometry/round_proxy.hpp"
#include "core/geometry/solid_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {
namespace {

/// Computes the contact with a hollow cylinder. The free space inside is convex, as for the box.
SurfacePoint cylinder_from_inside(const Cylinder& cylinder, const Vec3& p, FeatureMemory& memory) {
  const double h = cylinder.half_length;
  const Vec3 across(p.x(), p.y(), 0.0);
  const double beyond_side = std::max(0.0, length(across) - cylinder.radius);
  const double z = std::clamp(p.z(), -h, h);
  const Vec3 beyond = beyond_side * direction(across) + (p.z() - z) * Vec3::UnitZ();
  const double depth = length(beyond);
  if (!(depth > 0.0)) return no_contact(memory);
  const Vec3 at_side = beyond_side > 0.0 ? Vec3(cylinder.radius * direction(across)) : across;
  const int feature = beyond_side >= std::abs(p.z() - z) ? kCylinderSide
                      : p.z() > 0.0                      ? kCylinderTop
                                                         : kCylinderBottom;
  return stand_on(at_side + z * Vec3::UnitZ(), -direction(beyond), depth, feature, memory);
}

/// Returns the index of the face through which the path enters the cylinder, or -1 if the path does
/// not enter. The path begins outside the cylinder.
int cylinder_entry(const Cylinder& cylinder, const Vec3& from, const Vec3& to) {
  const double h = cylinder.half_length, r = cylinder.radius;
  const Vec3 flat(1.0, 1.0, 0.0);
  if ((from.z() >= h && to.z() >= h) || (from.z() <= -h && to.z() <= -h)) return -1;
  const Vec3 start = from.cwiseProduct(flat), end = to.cwiseProduct(flat);
  Span side{0.0, 1.0};
  if (!(length(start) < r && length(end) < r)) side = within(start, end - start, r);
  int face = length(start) < r ? -1 : kCylinderSide;
  const double down = to.z() - from.z();
  for (const double sign : {1.0, -1.0}) {
    const double before = sign * from.z() - h, after = sign * to.z() - h;
    const double part = -before / (sign * down);
    if (before >= 0.0) {
      if (face >= 0 && !(part > side.in)) continue;
      side.in = part;
      face = sign > 0.0 ? kCylinderTop : kCylinderBottom;
    } else if (after >= 0.0) {
      side.out = std::min(side.out, part);
    }
  }
  return side.in < side.out ? face : -1;
}

/// Computes the contact with the side, the lateral surface. Between the ends, it is part of an
/// infinite cylinder.
SurfacePoint cylinder_side(const Cylinder& cylinder, const Vec3& p, FeatureMemory& memory) {
  if (!(std::abs(p.z()) < cylinder.half_length)) return free_at(p, memory);
  Vec3 undefined = memory.normal;
  undefined.z() = 0.0;  // Before the first contact, memory.normal is along z.
  if (undefined.isZero(0.0)) undefined = Vec3::UnitX();
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  return round_from_outside({cylinder.radius, kEndless}, p, undefined, memory);
}

}  // namespace

SurfacePoint Cylinder::surface_point(Side side, const Vec3& p,
                                     FeatureMemory& memory) const noexcept {
  if (side == Side::inside) return cylinder_from_inside(*this, p, memory);
  const double h = half_length, r = radius;
  const Vec3 across(p.x(), p.y(), 0.0);
  const double distance = length(across);
  const bool inside = distance < r && std::abs(p.z()) < h;

  int feature = static_cast<int>(memory.feature) - 1;
  if (feature < kCylinderSide || feature > kCylinderBottom) {
    const double off = std::max(distance - r, std::abs(p.z()) - h);
    feature = memory.tracked && !cannot_have_met(off, p - memory.proxy)
                  ? cylinder_entry(*this, memory.proxy, p)
                  : -1;
    if (feature < 0 && !inside) return free_at(p, memory);
    if (feature < 0) {
      const bool side_is_nearer = r - distance < h - std::abs(p.z());
      feature = side_is_nearer ? kCylinderSide : p.z() < 0.0 ? kCylinderBottom : kCylinderTop;
    }
  }

  if (feature != kCylinderSide) {
    const double sign = feature == kCylinderTop ? 1.0 : -1.0;
    const double depth = h - sign * p.z();
    if (!(distance < r) || !(depth > 0.0)) return free_at(p, memory);
    const Vec3 point(p.x(), p.y(), sign * h);
    return held_on({point, sign * Vec3::UnitZ(), depth}, feature, memory);
  }
  return cylinder_side(*this, p, memory);
}

Grown<Cylinder> Cylinder::grown(Side side, double ball) const noexcept {
  if (side == Side::outside) return {*this, Vec3::Zero(), ball};
  return {{radius - ball, half_length - ball}};
}

double Cylinder::room() const noexcept { return std::min(radius, half_length); }

FieldPoint Cylinder::signed_distance(const Vec3& p) const noexcept {
  const Polar<double> across = polar(Vec3(p.x(), p.y(), 0.0));
  const Vec3 outward = across.length > 0.0 ? across.direction : Vec3::UnitX();
  const Vec3 up = p.z() < 0.0 ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitZ());
  const double to_side = across.length - radius;
  const double to_end = std::abs(p.z()) - half_length;
  if (to_side > 0.0 && to_end > 0.0) {
    const Polar<double> way = polar(Vec3(to_side * outward + to_end * up));
    return {way.length, way.direction};
  }
  return to_side > to_end ? FieldPoint{to_side, outward} : FieldPoint{to_end, up};
}

Vec3 Cylinder::half_box() const noexcept { return {radius, radius, half_length}; }

double Cylinder::reach() const noexcept { return std::hypot(radius, half_length); }

MassProperties Cylinder::mass_properties() const {
  const double volume = 2.0 * std::numbers::pi * radius * radius * half_length;
  const double r = radius * radius, h = half_length * half_length;
  return {volume, Vec3::Zero(), volume * inertia_about_z(r / 4.0 + h / 3.0, r / 2.0)};
}

TriangleSoup Cylinder::triangles(int segments) const {
  const double h = half_length;
  return revolved({{0.0, h}, {radius, h}, {radius, -h}, {0.0, -h}}, segments);
}

std::vector<PhysicsGeom> Cylinder::geoms(Side side) const {
  if (side == Side::inside) return {};
  return {{.kind = PhysicsGeom::Kind::cylinder, .size = {radius, half_length, 0.0}}};
}

SurfaceParts Cylinder::parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept {
  SurfaceParts all;
  const double h = half_length, distance = root(p.x(), p.y());
  const double to_side = std::max(0.0, radius - distance);
  const double to_top = std::max(0.0, h - p.z()), to_bottom = std::max(0.0, h + p.z());
  if (side == Side::inside) {
    add(all, to_side, feature_of(kCylinderSide));
    add(all, to_top, feature_of(kCylinderTop));
    add(all, to_bottom, feature_of(kCylinderBottom));
    return all;
  }
  const double across = std::max(0.0, distance - radius);
  const double along = std::max(0.0, std::abs(p.z()) - h);
  const double solid = root(across, along);
  add_convex(all, root(to_side, along), solid, kCylinderSide, entered);
  add_convex(all, root(to_top, across), solid, kCylinderTop, entered);
  add_convex(all, root(to_bottom, across), solid, kCylinderBottom, entered);
  return all;
}

PatchGeometry Cylinder::patch(Side side, const Vec3& p, int face, const FeatureMemory& memory,
                              bool touching) const noexcept {
  const double h = half_length, z = std::clamp(p.z(), -h, h);
  PatchGeometry s;
  if (face == kCylinderSide) {
    const Vec3 outward = across_axis(p, memory);
    const Vec3* behind = left_behind(side, face, outward, memory, touching);
    s = round_patch(side, Vec3(0.0, 0.0, z), behind != nullptr ? *behind : outward, radius);
    s.axis = Vec3::UnitZ();
  } else {
    const double up = face == kCylinderTop ? 1.0 : -1.0;
    const double distance = root(p.x(), p.y());
    const double in = distance > radius ? radius / distance : 1.0;
    s.point = {in * p.x(), in * p.y(), up * h};
    s.normal = (side == Side::outside ? up : -up) * Vec3::UnitZ();
  }
  s.joined = side == Side::outside;
  return s;
}

}  // namespace feltwire

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/geometry/round_proxy.hpp"
#include "core/geometry/solid_proxy.hpp"

namespace feltwire {
namespace {

/// Seen from within, the cylinder is convex for the proxy, as the box is.
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

/// The face by which the way from a free point goes in; -1: it does not.
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

/// Its side, as far as its ends, is part of an endless pipe's.
SurfacePoint cylinder_side(const Cylinder& cylinder, const Vec3& p, FeatureMemory& memory) {
  if (!(std::abs(p.z()) < cylinder.half_length)) return free_at(p, memory);
  Vec3 undefined = memory.normal;
  undefined.z() = 0.0;  // a normal remembered from before the first contact is along z
  if (undefined.isZero(0.0)) undefined = Vec3::UnitX();
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  return round_from_outside({cylinder.radius, kEndless}, p, undefined, memory);
}

}  // namespace

SurfacePoint surface_point(const Cylinder& cylinder, Side side, const Vec3& p,
                           FeatureMemory& memory) noexcept {
  if (side == Side::inside) return cylinder_from_inside(cylinder, p, memory);
  const double h = cylinder.half_length, r = cylinder.radius;
  const Vec3 across(p.x(), p.y(), 0.0);
  const double distance = length(across);
  const bool inside = distance < r && std::abs(p.z()) < h;

  int feature = static_cast<int>(memory.feature) - 1;
  if (feature < kCylinderSide || feature > kCylinderBottom) {
    const double off = std::max(distance - r, std::abs(p.z()) - h);
    feature = memory.tracked && !cannot_have_met(off, p - memory.proxy)
                  ? cylinder_entry(cylinder, memory.proxy, p)
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
  return cylinder_side(cylinder, p, memory);
}

}  // namespace feltwire

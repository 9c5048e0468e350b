#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/geometry/segment.hpp"
#include "core/guidance/guide.hpp"

namespace feltwire {
namespace {

ClosestPoint from(const Vec3& nearest, const Vec3& p) {
  const Polar<double> offset = polar(Vec3(p - nearest));
  return {offset.direction, offset.length};
}

/// A surface at `radius` round the nearest point of a solid's core.
ClosestPoint round(const Vec3& core, double radius, const Vec3& p) {
  ClosestPoint foot = from(core, p);
  foot.distance -= radius;
  return foot;
}

Vec3 on_axis(double half_length, const Vec3& p) {
  return {0.0, 0.0, std::clamp(p.z(), -half_length, half_length)};
}

ClosestPoint foot_of(const GuideCurve& curve, const Vec3& p) {
  const std::size_t count = curve.points.size();
  ClosestPoint best{Vec3::Zero(), std::numeric_limits<double>::infinity()};
  for (std::size_t i = 0; i + 1 < count || (curve.closed && i < count); ++i) {
    const Vec3 &a = curve.points[i], &b = curve.points[(i + 1) % count];
    const ClosestPoint here = from(nearest_on_segment(a, b, p).point, p);
    if (here.distance < best.distance) best = here;
  }
  return best;
}

/// A convex solid that is `beyond` [m] along its axes, each < 0 where p is within: `axes` are the
/// outward directions.
template <std::size_t kAxes>
ClosestPoint convex(const std::array<double, kAxes>& beyond, const std::array<Vec3, kAxes>& axes) {
  Vec3 out = Vec3::Zero();
  std::size_t nearest = 0;
  for (std::size_t i = 0; i < kAxes; ++i) {
    out += std::max(0.0, beyond[i]) * axes[i];
    if (beyond[i] > beyond[nearest]) nearest = i;
  }
  if (!(beyond[nearest] > 0.0)) return {axes[nearest], beyond[nearest]};
  return from(Vec3::Zero(), out);
}

Vec3 signed_axis(const Vec3& p, int axis) { return std::copysign(1.0, p[axis]) * Vec3::Unit(axis); }

ClosestPoint foot_of(const Box& box, const Vec3& p) {
  const Vec3 beyond = p.cwiseAbs() - box.half_extents;
  return convex<3>({beyond.x(), beyond.y(), beyond.z()},
                   {signed_axis(p, 0), signed_axis(p, 1), signed_axis(p, 2)});
}

ClosestPoint foot_of(const Cylinder& cylinder, const Vec3& p) {
  const Polar<double> across = polar(Vec3(p.x(), p.y(), 0.0));
  return convex<2>({across.length - cylinder.radius, std::abs(p.z()) - cylinder.half_length},
                   {across.direction, signed_axis(p, 2)});
}

}  // namespace

ClosestPoint closest_point(const GuidePlace& place, const Vec3& p) noexcept {
  // get_if instead of visit: visit may throw, and this is the servo loop.
  if (std::get_if<GuidePoint>(&place) != nullptr) return from(Vec3::Zero(), p);
  if (const auto* line = std::get_if<GuideLine>(&place))
    return from(on_axis(line->half_length, p), p);
  if (const auto* curve = std::get_if<GuideCurve>(&place)) return foot_of(*curve, p);
  if (std::get_if<GuidePlane>(&place) != nullptr) return {Vec3::UnitZ(), p.z()};
  if (const auto* sphere = std::get_if<Sphere>(&place))
    return round(Vec3::Zero(), sphere->radius, p);
  if (const auto* box = std::get_if<Box>(&place)) return foot_of(*box, p);
  if (const auto* capsule = std::get_if<Capsule>(&place))
    return round(on_axis(capsule->half_length, p), capsule->radius, p);
  if (const auto* cylinder = std::get_if<Cylinder>(&place)) return foot_of(*cylinder, p);
  return {};
}

}  // namespace feltwire

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/geometry/segment.hpp"
#include "core/guidance/guide.hpp"

namespace feltwire {
namespace {

ClosestPoint from(const Vec3& nearest, const Vec3& p) {
  const Polar<double> offset = polar(Vec3(p - nearest));
  return {offset.direction, offset.length};
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

}  // namespace

ClosestPoint closest_point(const GuidePlace& place, const Vec3& p) noexcept {
  if (std::get_if<GuidePoint>(&place) != nullptr) return from(Vec3::Zero(), p);
  if (const auto* line = std::get_if<GuideLine>(&place)) {
    const double h = line->half_length;
    return from(Vec3(0.0, 0.0, std::clamp(p.z(), -h, h)), p);
  }
  if (const auto* curve = std::get_if<GuideCurve>(&place)) return foot_of(*curve, p);
  return on_primitive(
      place,
      [&](const auto& solid) {
        const FieldPoint field = solid.signed_distance(p);
        return ClosestPoint{field.gradient, field.distance};
      },
      [] { return ClosestPoint{}; });
}

}  // namespace feltwire

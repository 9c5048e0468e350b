#pragma once
// The proxy on a round surface (a ball, a rod, a pipe). If the surface is felt from outside, the
// proxy remembers its side.

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"
#include "core/geometry/primitive.hpp"
#include "core/geometry/solid_proxy.hpp"

namespace feltwire {

/// A solid of all points within `radius` of a piece of the z axis, from -half_length to
/// +half_length: a point (a ball), a segment (a capsule), or the whole axis (infinite: an endless
/// pipe).
struct RoundSolid {
  double radius = 0.0;       // [m] > 0
  double half_length = 0.0;  // [m] >= 0

  Vec3 core(const Vec3& p) const {
    return {0.0, 0.0, std::clamp(p.z(), -half_length, half_length)};
  }
  /// Returns the point of the core below the proxy with this normal.
  Vec3 core_of(const Vec3& normal, const Vec3& p) const {
    if (normal.z() > 0.0 && std::isfinite(half_length)) return {0.0, 0.0, half_length};
    if (normal.z() < 0.0 && std::isfinite(half_length)) return {0.0, 0.0, -half_length};
    return core(p);
  }
};

/// Returns the part of a path, 0 to 1, that is within a radius of the origin: empty unless in <
/// out.
struct Span {
  double in = 1.0, out = 0.0;
};
inline Span within(const Vec3& from, const Vec3& way, double radius) {
  const double a = way.squaredNorm(), b = from.dot(way);
  const double root = b * b - a * (from.squaredNorm() - radius * radius);
  if (!(a > 0.0) || !(root > 0.0)) return {};
  return {std::max(0.0, (-b - std::sqrt(root)) / a), std::min(1.0, (-b + std::sqrt(root)) / a)};
}
/// Returns the part of a path that is in the solid.
inline Span within(const RoundSolid& solid, const Vec3& from, const Vec3& way) {
  const double h = solid.half_length;
  const Vec3 end(0.0, 0.0, h);
  if (!(h > 0.0)) return within(from, way, solid.radius);
  const Vec3 flat(1.0, 1.0, 0.0);
  const Vec3 start = from.cwiseProduct(flat), across = way.cwiseProduct(flat);
  Span side{0.0, 1.0};
  if (across.isZero(0.0) ? !(start.squaredNorm() < solid.radius * solid.radius) : true)
    side = within(start, across, solid.radius);
  if (!std::isfinite(h)) return side;
  const auto cut =
      [&](double before,
          double after) {  // limits the path to the part where the height is below zero
        if (before >= 0.0 && after >= 0.0) side = {};
        if (before >= 0.0) side.in = std::max(side.in, before / (before - after));
        if (after >= 0.0) side.out = std::min(side.out, before / (before - after));
      };
  cut(from.z() - h, from.z() + way.z() - h);
  cut(-from.z() - h, -from.z() - way.z() - h);
  Span all;
  for (const Span& part :
       {side, within(from - end, way, solid.radius), within(from + end, way, solid.radius)}) {
    if (!(part.in < part.out)) continue;
    all = all.in < all.out ? Span{std::min(all.in, part.in), std::max(all.out, part.out)} : part;
  }
  return all;
}

/// The proxy goes down the distance to the hand, as on any surface. But one step over the surface
/// is at most kMostTurning times the hand's movement about the core, and there is no step while the
/// hand is beyond the middle, as seen from the proxy. A hand that is no deeper than the radius less
/// radius / kMostTurning never moves about the core faster than that, and its proxy is the nearest
/// point of the surface. A hand that is pressed on through the middle, or beside it by less than
/// some 4 % of the radius, leaves its proxy behind, on the side from which it came. A proxy with
/// dry friction makes such steps over a surface, too: they take energy, and give none.
inline constexpr double kMostTurning = 4.0;

/// Returns the unit vector that `normal` reaches if it turns by at most `most` [rad].
inline Vec3 turned(const Vec3& normal, const Vec3& towards, double most) {
  constexpr double kChordOfArc = 2.0 / std::numbers::pi;  // a lower bound
  const double chord = length(Vec3(towards - normal));
  if (!(chord > kChordOfArc * most)) return towards;  // the angle is at most pi / 2 chords
  if (2.0 * std::asin(std::min(1.0, 0.5 * chord)) <= most) return towards;
  const Vec3 across = direction(Vec3(towards - towards.dot(normal) * normal));
  return direction(Vec3(std::cos(most) * normal + std::sin(most) * across));
}

/// Whether a hand that is out of the solid, on the far side from the proxy with this normal, has
/// the solid in between: the straight way back along the normal passes through it.
inline bool holds_behind(const RoundSolid& solid, const Vec3& normal, const Vec3& p) {
  const Vec3 offset = p - solid.core_of(normal, p);
  const double along_normal = normal.dot(offset);
  return !(along_normal > 0.0) && length(Vec3(offset - along_normal * normal)) < solid.radius;
}

/// Returns the normal of the proxy after the hand has moved straight from `from` to `to`, both
/// within the solid or beyond it on the way through. `normal` is the one before; unit.
inline Vec3 round_normal(const RoundSolid& solid, const Vec3& from, const Vec3& to, Vec3 normal) {
  constexpr double kSteps = 32.0;  // in a radius
  constexpr int kMostSteps = 64;
  const Vec3 way = to - from;
  Vec3 before = from - solid.core(from);
  // Only the movement about the core: movement along it does not turn the normal.
  const double steps =
      std::ceil(kSteps * length(Vec3(to - solid.core(to) - before)) / solid.radius);
  // A hostile local model may have a radius below zero, or none that is finite.
  const int count = !(steps > 1.0) ? 1 : steps < kMostSteps ? static_cast<int>(steps) : kMostSteps;
  for (int n = 1; n <= count; ++n) {
    const Vec3 p = n == count ? to : Vec3(from + (static_cast<double>(n) / count) * way);
    const Vec3 offset = p - solid.core(p);
    const double moved = length(Vec3(offset - before));
    before = offset;
    if (!(normal.dot(p - solid.core_of(normal, p)) > 0.0)) continue;  // beyond the middle
    const Vec3 outward = direction(offset);
    if (!outward.isZero(0.0)) normal = turned(normal, outward, kMostTurning * moved / solid.radius);
  }
  return normal;
}

/// The signed distance to the points within a radius of its core; `core` is its nearest point to p.
/// `undefined`: the gradient on the core.
inline FieldPoint round_distance(const Vec3& core, double radius, const Vec3& p,
                                 const Vec3& undefined) {
  const Polar<double> out = polar(Vec3(p - core));
  return {out.length - radius, out.length > 0.0 ? out.direction : undefined};
}

/// A hollow at `radius` round `core`, the nearest point of the shape's core (centre, axis).
SurfacePoint hollow_surface(const Vec3& p, const Vec3& core, double radius, FeatureMemory& memory);
/// A solid felt from outside. `undefined` is the outward direction to use if p lies on the core
/// itself.
SurfacePoint round_from_outside(const RoundSolid& solid, const Vec3& p, const Vec3& undefined,
                                FeatureMemory& memory);

}  // namespace feltwire

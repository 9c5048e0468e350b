#include "core/geometry/cone.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/geometry/local_curvature.hpp"
#include "core/geometry/revolution.hpp"
#include "core/geometry/round_proxy.hpp"
#include "core/geometry/solid_proxy.hpp"
#include "core/geometry/surface_parts.hpp"

namespace feltwire {
namespace {

/// A cone relative to a point p, in the half plane through the axis and p. The side is the lateral
/// surface of the cone.
struct ConeView {
  ConeView(const Cone& cone, const Vec3& p) : radius(cone.radius), half_length(cone.half_length) {
    slant = hypotenuse(radius, 2.0 * half_length);
    sine = radius / slant;
    cosine = 2.0 * half_length / slant;
    const Vec3 flat(p.x(), p.y(), 0.0);
    across = length(flat);
    outward = direction(flat);
    below_side = (half_length - p.z()) * sine - across * cosine;
    above_base = half_length + p.z();
    along = across * sine + (half_length - p.z()) * cosine;
  }
  bool is_inside() const { return below_side > 0.0 && above_base > 0.0; }
  /// Returns the outward normal of the side. `facing` is the unit vector from the axis to this part
  /// of the side.
  Vec3 normal(const Vec3& facing) const { return cosine * facing + sine * Vec3::UnitZ(); }
  /// Returns the unit vector along the side, from the tip to the rim.
  Vec3 down(const Vec3& facing) const { return sine * facing - cosine * Vec3::UnitZ(); }
  Vec3 tip() const { return half_length * Vec3::UnitZ(); }
  Vec3 on_side(const Vec3& facing, double from_tip) const {
    return tip() + from_tip * down(facing);
  }

  double radius, half_length, slant;
  double sine, cosine;  // sine and cosine of the angle between the axis and the side
  double across;        // [m] distance of p from the axis
  Vec3 outward;         // unit vector from the axis to p; zero on the axis
  double below_side;    // [m] depth of p below the infinitely extended side
  double above_base;    // [m] height of p above the plane of the base
  double along;         // [m] distance from the tip to the point of the side closest to p
};

/// The point of the solid that is closest to a point outside.
struct ConeClosest {
  // `away`: unit vector from `point` to the outside point.
  Vec3 point = Vec3::Zero(), away = Vec3::Zero();
  double distance = std::numeric_limits<double>::infinity();
  int face = kConeSide;
};
ConeClosest closest_on(const ConeView& view, const Vec3& p) {
  ConeClosest best;
  const auto offer = [&](const Vec3& point, const Vec3& away, double distance, int face) {
    if (distance < best.distance) best = {point, away, distance, face};
  };
  const Vec3 outward = or_else(view.outward, Vec3::UnitX());
  const auto offer_edge = [&](const Vec3& point, int face) {
    const Polar<double> way = polar(Vec3(p - point));
    offer(point, way.direction, way.length, face);
  };
  if (view.below_side < 0.0) {
    if (view.along > 0.0 && view.along < view.slant)
      offer(view.on_side(outward, view.along), view.normal(outward), -view.below_side, kConeSide);
    else
      offer_edge(view.on_side(outward, std::clamp(view.along, 0.0, view.slant)), kConeSide);
  }
  if (view.above_base < 0.0) {
    const Vec3 base(0.0, 0.0, -view.half_length);
    if (view.across < view.radius)
      offer(Vec3(p.x(), p.y(), base.z()), -Vec3::UnitZ(), -view.above_base, kConeBase);
    else
      offer_edge(base + view.radius * outward, kConeBase);
  }
  return best;
}

/// Computes the contact with a hollow cone. The free space inside is convex, as for the box.
SurfacePoint cone_from_inside(const Cone& cone, const Vec3& p, FeatureMemory& memory) {
  const ConeClosest closest = closest_on(ConeView(cone, p), p);
  if (!(closest.distance > 0.0) || !std::isfinite(closest.distance)) return no_contact(memory);
  return stand_on(closest.point, -closest.away, closest.distance, closest.face, memory);
}

/// The part of a path that is inside the cone, and the face through which the path enters.
struct ConeSpan : Span {
  int face = kConeSide;
};
ConeSpan way_within(const Cone& cone, const Vec3& from, const Vec3& way) {
  const double h = cone.half_length, length_unit = std::max(cone.radius, h);
  ConeSpan span{{0.0, 1.0}};
  // Clip the path to heights above the base and below the tip.
  const auto cut = [&](double before, double change, int face) {
    if (before <= 0.0) {
      if (!(before + change > 0.0)) {
        span.in = 1.0, span.out = 0.0;
      } else if (-before / change >= span.in) {
        span.in = -before / change;
        span.face = face;
      }
    } else if (before + change <= 0.0) {
      span.out = std::min(span.out, -before / change);
    }
  };
  cut(from.z() + h, way.z(), kConeBase);
  cut(h - from.z(), -way.z(), kConeSide);
  if (!(span.in < span.out)) return span;

  // Clip the path to the part inside the side, where a x^2 + 2 b x + c < 0 for the position x on
  // the path.
  const double slope = cone.radius / (2.0 * h);
  const Vec3 start = Vec3(from.x(), from.y(), slope * (h - from.z())) / length_unit;
  const Vec3 going = Vec3(way.x(), way.y(), -slope * way.z()) / length_unit;
  const auto form = [](const Vec3& u, const Vec3& v) {
    return u.x() * v.x() + u.y() * v.y() - u.z() * v.z();
  };
  const double a = form(going, going), b = form(start, going), c = form(start, start);
  const double square = b * b - a * c;
  const auto in_from = [&](double x) {
    if (!(x > span.in)) return;
    span.in = x;
    span.face = kConeSide;
  };
  if (!(square > 0.0)) {
    // The path runs along the axis, or passes beside the cone.
    if (!(c < 0.0)) span.in = 1.0, span.out = 0.0;
    return span;
  }
  // Compute both roots in the form without cancellation.
  const double q = -(b + std::copysign(std::sqrt(square), b));
  double low = a != 0.0 ? q / a : -std::numeric_limits<double>::infinity();
  double high = q != 0.0 ? c / q : 0.0;
  if (a != 0.0 && low > high) std::swap(low, high);
  if (a > 0.0) {
    in_from(low);
    span.out = std::min(span.out, high);
  } else if (going.z() > 0.0) {  // The path enters: it goes down, steeper than the side.
    in_from(a < 0.0 ? high : c / q);
  } else {
    span.out = std::min(span.out, a < 0.0 ? low : c / q);
  }
  return span;
}

/// Computes the contact with the side. The proxy turns about the axis with the tool, as on a
/// cylinder with the cone's radius at the tool's height. If the tool pulls the proxy over the tip,
/// the proxy continues on the tool's side of the axis.
SurfacePoint cone_side(const Cone& cone, const ConeView& view, const Vec3& from, const Vec3& p,
                       Vec3 facing, FeatureMemory& memory) {
  const double wide = (view.half_length - p.z()) * view.sine / view.cosine;
  if (!(wide > 0.0)) return free_at(p, memory);
  constexpr double kEndless = std::numeric_limits<double>::infinity();
  facing = round_normal(RoundSolid{wide, kEndless}, from, p, facing);
  const Vec3 offset = p - view.tip();
  if (!(offset.dot(view.down(facing)) > 0.0)) facing = or_else(view.outward, facing);

  const Vec3 normal = view.normal(facing);
  const bool nearest = facing == view.outward;
  const double under = nearest ? view.below_side : -normal.dot(offset);
  if (!(under > 0.0)) return free_at(p, memory);
  // A tool that has left the solid is still in contact if the straight line from the tool to the
  // side crosses the solid.
  if (!view.is_inside()) {
    const Span back = way_within(cone, p, under * normal);
    if (!(back.in < back.out)) return free_at(p, memory);
  }
  SurfacePoint on{p + under * normal, normal, under};
  if (!nearest) {
    on.point = view.on_side(facing, std::max(0.0, offset.dot(view.down(facing))));
    const Polar<double> back = polar(Vec3(on.point - p));
    on.depth = back.length;
    if (back.length > 0.0) on.normal = back.direction;
  }
  held_on({on.point, normal, on.depth}, kConeSide, memory);
  memory.proxy = p;  // For a round surface, the memory stores the tool's position.
  return on;
}

/// Returns the extent [m] of a patch about a point of the side at the distance `across` [m] from
/// the axis. Within this extent, a cylinder approximates the cone. At a cone angle of 45 degrees,
/// the error is half of kPatchSlope times the extent. At other angles, the error is smaller.
double side_extent(double across) {
  constexpr double kOfRadius = 0.25;
  return kOfRadius * across;
}

}  // namespace

SurfacePoint Cone::surface_point(Side side, const Vec3& p, FeatureMemory& memory) const noexcept {
  if (side == Side::inside) return cone_from_inside(*this, p, memory);
  const ConeView view(*this, p);
  int face = static_cast<int>(memory.feature) - 1;
  Vec3 from = memory.proxy;
  Vec3 facing = direction(Vec3(memory.normal.x(), memory.normal.y(), 0.0));
  if (face != kConeSide && face != kConeBase) {
    face = -1;
    from = p;
    facing = or_else(view.outward, facing);
    const double off = std::max(-view.below_side, -view.above_base);
    const Vec3 way = p - memory.proxy;
    if (memory.tracked && !cannot_have_met(off, way)) {
      const ConeSpan in = way_within(*this, memory.proxy, way);
      if (in.in < in.out) {
        face = in.face;
        from = memory.proxy + in.in * way;
        facing = or_else(direction(Vec3(from.x(), from.y(), 0.0)), facing);
      }
    }
    if (face < 0 && !view.is_inside()) return free_at(p, memory);
    if (face < 0) face = view.below_side < view.above_base ? kConeSide : kConeBase;
  }
  if (face == kConeSide)
    return cone_side(*this, view, from, p, or_else(facing, Vec3::UnitX()), memory);
  if (!(view.across < radius) || !(view.above_base > 0.0)) return free_at(p, memory);
  return held_on({Vec3(p.x(), p.y(), -half_length), -Vec3::UnitZ(), view.above_base}, kConeBase,
                 memory);
}

Grown<Cone> Cone::grown(Side side, double ball) const noexcept {
  if (side == Side::outside) return {*this, Vec3::Zero(), ball};
  // Use a smaller cone with the same angle. The distance between the sides and between the bases of
  // both cones is the ball's radius.
  const double sine = radius / hypotenuse(radius, 2.0 * half_length);
  const double top = half_length - ball / sine, bottom = ball - half_length;
  const double half = 0.5 * (top - bottom);
  return {{radius * half / half_length, half}, Vec3(0.0, 0.0, 0.5 * (top + bottom))};
}

double Cone::room() const noexcept {
  return radius * 2.0 * half_length / (radius + hypotenuse(radius, 2.0 * half_length));
}

FieldPoint Cone::signed_distance(const Vec3& p) const noexcept {
  const ConeView view(*this, p);
  const ConeClosest closest = closest_on(view, p);
  if (std::isfinite(closest.distance)) return {closest.distance, closest.away};
  if (view.above_base < view.below_side) return {-view.above_base, -Vec3::UnitZ()};
  return {-view.below_side, view.normal(or_else(view.outward, Vec3::UnitX()))};
}

Vec3 Cone::half_box() const noexcept { return {radius, radius, half_length}; }

double Cone::reach() const noexcept { return std::hypot(radius, half_length); }

MassProperties Cone::mass_properties() const {
  const double height = 2.0 * half_length, square = radius * radius;
  const double volume = std::numbers::pi / 3.0 * square * height;
  return {volume, Vec3(0.0, 0.0, -0.5 * half_length),
          volume * inertia_about_z(0.15 * square + 0.0375 * height * height, 0.3 * square)};
}

TriangleSoup Cone::triangles(int segments) const {
  return revolved({{0.0, half_length}, {radius, -half_length}, {0.0, -half_length}}, segments);
}

std::vector<PhysicsGeom> Cone::geoms(Side side) const {
  constexpr int kSegments = 64;
  if (side == Side::inside) return {};
  return {{.kind = PhysicsGeom::Kind::hull, .hull = triangles(kSegments).vertices}};
}

SurfaceParts Cone::parts(Side side, const Vec3& p, std::uint32_t entered) const noexcept {
  SurfaceParts all;
  const ConeView view(*this, p);
  const Vec3 outward = or_else(view.outward, Vec3::UnitX());
  const double down = std::clamp(view.along, 0.0, view.slant);
  // [m] distance of p from the side.
  const double off = length(Vec3(p - view.on_side(outward, down)));
  const double extent = side_extent(down * view.sine);
  const double under = std::max(0.0, view.below_side), over = std::max(0.0, view.above_base);
  if (side == Side::inside) {
    add(all, under, feature_of(kConeSide));
    add(all, over, feature_of(kConeBase));
    add(all, std::max(under, extent - off), feature_of(kConeSide), false);
    return all;
  }
  const ConeClosest closest = closest_on(view, p);
  const double solid = std::isfinite(closest.distance) ? closest.distance : 0.0;
  // These values are lower bounds of the distance from p to any point beyond one face and within
  // the other.
  const double beyond_side = std::max(under, -view.above_base);
  const double beyond_base = std::max(over, -view.below_side);
  add_convex(all, beyond_side, solid, kConeSide, entered);
  add_convex(all, beyond_base, solid, kConeBase, entered);
  // Bound the distance from p to the surface beyond the side's patch. This surface is at least
  // `extent` away from the solid's point nearest to p, so its distance from p is larger
  // (Pythagoras).
  double rest = extent - off;
  if (entered != feature_of(kConeSide)) {
    if (solid > 0.0 && closest.face == kConeSide) rest = root(solid, extent);
    rest = std::max({rest, beyond_side, solid});
  }
  add(all, std::max(0.0, rest), feature_of(kConeSide), false);
  return all;
}

PatchGeometry Cone::patch(Side side, const Vec3& p, int face, const FeatureMemory& memory,
                          bool touching) const noexcept {
  const ConeView view(*this, p);
  const double sign = outward_sign(side);
  PatchGeometry s{.joined = side == Side::outside};
  if (face == kConeBase) {
    const Vec3 outward = std::min(view.across, radius) * view.outward;
    s.point = outward - half_length * Vec3::UnitZ();
    s.normal = -sign * Vec3::UnitZ();
    return s;
  }
  Vec3 facing = across_axis(p, memory);
  if (const Vec3* behind = left_behind(side, face, view.normal(facing), memory, touching))
    facing = or_else(direction(Vec3(behind->x(), behind->y(), 0.0)), facing);
  const double down = std::clamp((p - view.tip()).dot(view.down(facing)), 0.0, view.slant);
  s.point = view.on_side(facing, down);
  s.normal = sign * view.normal(facing);
  s.axis = view.down(facing);
  const double across = down * view.sine;
  if (across > 0.0) s.curvature = sign * view.cosine / across;
  return s;
}

}  // namespace feltwire

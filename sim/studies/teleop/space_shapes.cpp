#include "sim/studies/teleop/space_shapes.hpp"

#include <algorithm>
#include <array>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire::teleop::in_space {
namespace {

/// A point in a plane through the axis of the hole: its distance from the axis and its height above
/// the top of the block [m].
struct Flat {
  double across = 0.0, up = 0.0;
};

double distance(const Flat& a, const Flat& b) {
  return std::hypot(a.across - b.across, a.up - b.up);
}

/// Returns the point on the segment from a to b that is nearest to p.
Flat on_segment(const Flat& a, const Flat& b, const Flat& p) {
  const double x = b.across - a.across, y = b.up - a.up;
  const double share = ((p.across - a.across) * x + (p.up - a.up) * y) / (x * x + y * y);
  const double u = std::clamp(share, 0.0, 1.0);
  return {a.across + u * x, a.up + u * y};
}

NearestPlace nearest_of_hole(const Shape& s, const Vec3& point) {
  const Flat p{std::hypot(point.x(), point.y()), point.z() + s.sunk};
  const Flat rim{s.play + s.chamfer, 0.0}, neck{s.play, -s.chamfer}, corner{s.play, -s.depth};
  const std::array faces = {Flat{std::max(p.across, rim.across), 0.0}, on_segment(rim, neck, p),
                            on_segment(neck, corner, p),
                            Flat{std::min(p.across, s.play), -s.depth}};
  std::size_t best = 0;
  for (std::size_t i = 1; i < faces.size(); ++i)
    if (distance(faces[i], p) < distance(faces[best], p)) best = i;
  const double width = std::max(s.play, s.play + s.chamfer + std::min(0.0, p.up));
  NearestPlace near;
  near.free = p.up >= 0.0 || (p.across <= width && p.up >= -s.depth);
  near.face = static_cast<std::uint32_t>(best) + 1;
  const double turn = p.across > 0.0 ? faces[best].across / p.across : 0.0;
  near.point = Vec3(turn * point.x(), turn * point.y(), faces[best].up - s.sunk);
  return near;
}

}  // namespace

NearestPlace nearest_place(const Shape& s, const Vec3& point) {
  if (s.kind == Shape::Kind::hole) return nearest_of_hole(s, point);
  const Polar<double> from_middle = polar(point);
  return {.point = s.radius * from_middle.direction, .free = from_middle.length >= s.radius};
}

const Vec3& SurfaceProxy::follow(const Vec3& goal) {
  constexpr int kMost = 64;
  for (int i = 0; i < kMost && step(goal); ++i) continue;
  return place_;
}

/// Moves the proxy by a short step towards the goal. Returns false if the proxy has reached its
/// final position.
bool SurfaceProxy::step(const Vec3& goal) {
  constexpr double kShort = 1e-4, kNone = 1e-9;  // [m] longest step; slip that counts as none
  const Polar<double> way = polar(Vec3(goal - place_));
  if (!(way.length > 0.0)) return false;
  const Vec3 tried = place_ + std::min(way.length, kShort) * way.direction;
  const NearestPlace blocked = nearest_place(shape_, tried);
  if (blocked.free) {
    place_ = tried;
    return way.length > kShort;
  }
  const Vec3 normal = direction(Vec3(blocked.point - tried));
  // Move the proxy onto the surface if it is above the surface.
  place_ += std::min(0.0, (blocked.point - place_).dot(normal)) * normal;
  const Vec3 left = goal - place_;
  const double deep = std::max(0.0, -left.dot(normal));
  const Polar<double> side = polar(Vec3(left + deep * normal));
  const double slip = side.length - shape_.friction * deep;
  if (!(slip > kNone)) return false;
  const Vec3 moved =
      place_ + std::min(slip, kShort) * side.direction - std::min(deep, kShort) * normal;
  const NearestPlace there = nearest_place(shape_, moved);
  place_ = there.free ? moved : there.point;
  return true;
}

SurfacePrior wrong_model(const Shape& shape, const Vec3& tip) {
  constexpr double kDeeper = 2e-3, kSofter = 0.75;
  Shape model = shape;
  model.radius -= kDeeper;
  model.play += kDeeper;
  model.sunk += kDeeper;
  const NearestPlace near = nearest_place(model, tip);
  const Vec3 outward = near.free ? Vec3(tip - near.point) : Vec3(near.point - tip);
  const Vec3 normal = direction(outward);
  if (normal.isZero(0.0)) return {};
  return {.key = near.face,
          .point = near.point,
          .normal = normal,
          .stiffness = kSofter * shape.stiffness,
          .friction = shape.friction,
          .velocity = Vec3::Zero()};
}

}  // namespace feltwire::teleop::in_space

#include "core/grid/signed_distance.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

FieldPoint distance(const Plane&, const Vec3& p) { return {p.z(), Vec3::UnitZ()}; }

FieldPoint round(const Vec3& core, double radius, const Vec3& p, const Vec3& undefined) {
  const Polar<double> out = polar(Vec3(p - core));
  return {out.length - radius, out.length > 0.0 ? out.direction : undefined};
}

FieldPoint distance(const Sphere& sphere, const Vec3& p) {
  return round(Vec3::Zero(), sphere.radius, p, Vec3::UnitZ());
}

FieldPoint distance(const Capsule& capsule, const Vec3& p) {
  const double h = capsule.half_length;
  return round(Vec3(0.0, 0.0, std::clamp(p.z(), -h, h)), capsule.radius, p, Vec3::UnitX());
}

FieldPoint distance(const Box& box, const Vec3& p) {
  const Vec3 beyond = p.cwiseAbs() - box.half_extents;
  const auto sign = [&](Eigen::Index axis) { return p[axis] < 0.0 ? -1.0 : 1.0; };
  Eigen::Index axis;
  const double most = beyond.maxCoeff(&axis);
  if (!(most > 0.0)) return {most, sign(axis) * Vec3::Unit(axis)};
  Vec3 out = beyond.cwiseMax(0.0);
  for (Eigen::Index i = 0; i < 3; ++i) out[i] *= sign(i);
  const Polar<double> way = polar(out);
  return {way.length, way.direction};
}

FieldPoint distance(const Cylinder& cylinder, const Vec3& p) {
  const Polar<double> across = polar(Vec3(p.x(), p.y(), 0.0));
  const Vec3 outward = across.length > 0.0 ? across.direction : Vec3::UnitX();
  const Vec3 up = p.z() < 0.0 ? Vec3(-Vec3::UnitZ()) : Vec3(Vec3::UnitZ());
  const double to_side = across.length - cylinder.radius;
  const double to_end = std::abs(p.z()) - cylinder.half_length;
  if (to_side > 0.0 && to_end > 0.0) {
    const Polar<double> way = polar(Vec3(to_side * outward + to_end * up));
    return {way.length, way.direction};
  }
  return to_side > to_end ? FieldPoint{to_side, outward} : FieldPoint{to_end, up};
}

/// Of the solid, whichever side it is felt from.
FieldPoint of_solid(const Shape& shape, const Vec3& p) noexcept {
  // get_if instead of visit: visit may throw.
  if (const auto* grid = std::get_if<Grid>(&shape)) return grid->field->at(p);
  if (const auto* plane = std::get_if<Plane>(&shape)) return distance(*plane, p);
  if (const auto* sphere = std::get_if<Sphere>(&shape)) return distance(*sphere, p);
  if (const auto* box = std::get_if<Box>(&shape)) return distance(*box, p);
  if (const auto* capsule = std::get_if<Capsule>(&shape)) return distance(*capsule, p);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape)) return distance(*cylinder, p);
  return {std::numeric_limits<double>::quiet_NaN(), Vec3::Zero()};
}

struct Extent {
  Vec3 operator()(const Plane&) const {
    throw std::invalid_argument("a plane has no bounds to sample; take a box");
  }
  Vec3 operator()(const Sphere& s) const { return Vec3::Constant(s.radius); }
  Vec3 operator()(const Box& b) const { return b.half_extents; }
  Vec3 operator()(const Capsule& c) const { return {c.radius, c.radius, c.radius + c.half_length}; }
  Vec3 operator()(const Cylinder& c) const { return {c.radius, c.radius, c.half_length}; }
  Vec3 operator()(const Mesh&) const {
    throw std::invalid_argument("a mesh has a sampling of its own (mesh_distance.hpp)");
  }
  Vec3 operator()(const Grid&) const {
    throw std::invalid_argument("a grid is sampled already; sample what it was made from");
  }
};

}  // namespace

FieldPoint signed_distance(const Shape& shape, Side side, const Vec3& position) noexcept {
  FieldPoint point = of_solid(shape, position);
  if (side == Side::inside) {
    point.distance = -point.distance;
    point.gradient = -point.gradient;
  }
  return point;
}

double distance_at_least(const Shape& shape, Side side, const Vec3& position,
                         double wanted) noexcept {
  const double sign = side == Side::outside ? 1.0 : -1.0;
  if (const auto* grid = std::get_if<Grid>(&shape))
    return grid->field->at_least(position, sign, wanted);
  return sign * of_solid(shape, position).distance;
}

void signed_distance(const Shape& shape, Side side, FieldGroup& group) noexcept {
  if (const auto* grid = std::get_if<Grid>(&shape))
    grid->field->at(group);
  else
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
      group.put(lane, of_solid(shape, group.place(lane)));
  if (side == Side::outside) return;
  group.distance = -group.distance;
  group.gradient_x = -group.gradient_x;
  group.gradient_y = -group.gradient_y;
  group.gradient_z = -group.gradient_z;
}

void distance_at_least(const Shape& shape, Side side, FieldGroup& group,
                       const FieldGroup::Lanes& wanted) noexcept {
  const double sign = side == Side::outside ? 1.0 : -1.0;
  if (const auto* grid = std::get_if<Grid>(&shape))
    return grid->field->at_least(group, sign, wanted);
  for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
    group.distance[static_cast<Eigen::Index>(lane)] =
        sign * of_solid(shape, group.place(lane)).distance;
}

Solid solid_of(const Shape& shape) {
  const Vec3 half = std::visit(Extent{}, shape);
  return {-half, half, [shape](const Vec3& p) { return of_solid(shape, p).distance; }};
}

}  // namespace feltwire

#include "core/contact/shapes.hpp"

#include <algorithm>
#include <cmath>

#include "core/contact/mesh_contact.hpp"
#include "core/geometry/distance_grid.hpp"
#include "core/numeric.hpp"

namespace feltwire {
namespace {

// Every test for contact is written so that a NaN is free.

SurfacePoint free_point(FeatureMemory& memory) {
  memory = {};
  return {};
}

SurfacePoint contact(const Vec3& point, const Vec3& normal, double depth, int feature,
                     FeatureMemory& memory) {
  memory.feature = static_cast<std::uint8_t>(1 + feature);
  memory.normal = normal;
  return {point, normal, depth};
}

SurfacePoint surface(const Plane&, Side side, const Vec3& p, FeatureMemory& memory) {
  const double up = side == Side::outside ? 1.0 : -1.0;
  if (!(up * p.z() < 0.0)) return free_point(memory);
  return contact(Vec3(p.x(), p.y(), 0.0), Vec3(0.0, 0.0, up), -up * p.z(), 0, memory);
}

/// A surface at `radius` round `core`, the nearest point of the shape's core (centre, axis).
/// `undefined` is the outward direction to take when p lies on the core itself.
SurfacePoint round_surface(Side side, const Vec3& p, const Vec3& core, double radius,
                           const Vec3& undefined, FeatureMemory& memory) {
  const Vec3 offset = p - core;
  const double distance = length(offset);
  const bool free = side == Side::outside ? !(distance < radius) : !(distance > radius);
  if (free) return free_point(memory);
  const Vec3 outward = distance > 0.0 ? direction(offset) : undefined;
  return contact(core + radius * outward, side == Side::outside ? outward : Vec3(-outward),
                 std::abs(radius - distance), 0, memory);
}

SurfacePoint surface(const Sphere& sphere, Side side, const Vec3& p, FeatureMemory& memory) {
  return round_surface(side, p, Vec3::Zero(), sphere.radius, memory.normal, memory);
}

SurfacePoint surface(const Capsule& capsule, Side side, const Vec3& p, FeatureMemory& memory) {
  const double h = capsule.half_length;
  const Vec3 core(0.0, 0.0, std::clamp(p.z(), -h, h));
  // On the axis every direction across it is as near; beyond its ends so is the half sphere.
  Vec3 undefined = memory.normal;
  undefined.z() = std::clamp(undefined.z(), p.z() <= -h ? -1.0 : 0.0, p.z() >= h ? 1.0 : 0.0);
  undefined = undefined.isZero(0.0) ? Vec3::UnitX() : direction(undefined);
  return round_surface(side, p, core, capsule.radius, undefined, memory);
}

SurfacePoint box_from_outside(const Vec3& h, const Vec3& p, FeatureMemory& memory) {
  const bool inside = std::abs(p.x()) < h.x() && std::abs(p.y()) < h.y() && std::abs(p.z()) < h.z();
  if (!inside) return free_point(memory);

  // A convex solid holds the whole way between two points in it, so whoever is still inside has
  // crossed no other face since he entered. Only at entry is the nearest face asked for.
  int face = memory.feature - 1;
  if (face < 0 || face >= kBoxFaces) {
    Eigen::Index axis;
    (h - p.cwiseAbs()).minCoeff(&axis);
    face = 2 * static_cast<int>(axis) + (p[axis] < 0.0 ? 1 : 0);
  }
  const int axis = face / 2;
  const double sign = face % 2 == 0 ? 1.0 : -1.0;
  Vec3 point = p;
  point[axis] = sign * h[axis];
  return contact(point, sign * Vec3::Unit(axis), h[axis] - sign * p[axis], face, memory);
}

/// Seen from within, the box is convex for the proxy: it is the clamped point, on one face, an edge
/// or a corner, and the force runs along the line between.
SurfacePoint box_from_inside(const Vec3& h, const Vec3& p, FeatureMemory& memory) {
  const Vec3 point = p.cwiseMax(-h).cwiseMin(h);
  const Vec3 beyond = p - point;
  const double depth = length(beyond);
  if (!(depth > 0.0)) return free_point(memory);
  Eigen::Index axis;
  beyond.cwiseAbs().maxCoeff(&axis);
  const int face = 2 * static_cast<int>(axis) + (beyond[axis] < 0.0 ? 1 : 0);
  return contact(point, -direction(beyond), depth, face, memory);
}

SurfacePoint surface(const Box& box, Side side, const Vec3& p, FeatureMemory& memory) {
  return side == Side::outside ? box_from_outside(box.half_extents, p, memory)
                               : box_from_inside(box.half_extents, p, memory);
}

SurfacePoint surface(const Cylinder& cylinder, Side side, const Vec3& p, FeatureMemory& memory) {
  const double h = cylinder.half_length;
  const Vec3 across(p.x(), p.y(), 0.0);
  const double distance = length(across);

  if (side == Side::inside) {  // convex for the proxy, as the box is
    const double beyond_side = std::max(0.0, distance - cylinder.radius);
    const double z = std::clamp(p.z(), -h, h);
    const Vec3 beyond = beyond_side * direction(across) + (p.z() - z) * Vec3::UnitZ();
    const double depth = length(beyond);
    if (!(depth > 0.0)) return free_point(memory);
    const Vec3 at_side = beyond_side > 0.0 ? Vec3(cylinder.radius * direction(across)) : across;
    const int feature = beyond_side >= std::abs(p.z() - z) ? kCylinderSide
                        : p.z() > 0.0                      ? kCylinderTop
                                                           : kCylinderBottom;
    return contact(at_side + z * Vec3::UnitZ(), -direction(beyond), depth, feature, memory);
  }

  if (!(distance < cylinder.radius && std::abs(p.z()) < h)) return free_point(memory);
  int feature = memory.feature - 1;
  if (feature < kCylinderSide || feature > kCylinderBottom) {
    const bool side_is_nearer = cylinder.radius - distance < h - std::abs(p.z());
    feature = side_is_nearer ? kCylinderSide : p.z() < 0.0 ? kCylinderBottom : kCylinderTop;
  }
  if (feature == kCylinderSide) {
    Vec3 outward = distance > 0.0 ? direction(across) : memory.normal;
    outward.z() = 0.0;  // a normal remembered from before the first contact is along z
    if (outward.isZero(0.0)) outward = Vec3::UnitX();
    return contact(cylinder.radius * outward + p.z() * Vec3::UnitZ(), outward,
                   cylinder.radius - distance, feature, memory);
  }
  const double sign = feature == kCylinderTop ? 1.0 : -1.0;
  return contact(Vec3(p.x(), p.y(), sign * h), sign * Vec3::UnitZ(), h - sign * p.z(), feature,
                 memory);
}

SurfacePoint surface(const Grid& grid, Side side, const Vec3& p, FeatureMemory& memory) {
  const FieldPoint field = grid.field->at(p);
  const double below = side == Side::outside ? -field.distance : field.distance;
  if (!(below > 0.0)) return free_point(memory);
  const Polar<double> out = polar(field.gradient);
  if (!(out.length > 0.0)) return contact(p, memory.normal, 0.0, 0, memory);
  const Vec3 normal = side == Side::outside ? out.direction : Vec3(-out.direction);
  const double depth = below * out.length;
  return contact(p + depth * normal, normal, depth, 0, memory);
}

}  // namespace

SurfacePoint surface_point(const Shape& shape, Side side, const Vec3& position,
                           FeatureMemory& memory) noexcept {
  // get_if instead of visit: visit may throw, and this is the servo loop.
  if (const auto* plane = std::get_if<Plane>(&shape))
    return surface(*plane, side, position, memory);
  if (const auto* sphere = std::get_if<Sphere>(&shape))
    return surface(*sphere, side, position, memory);
  if (const auto* box = std::get_if<Box>(&shape)) return surface(*box, side, position, memory);
  if (const auto* capsule = std::get_if<Capsule>(&shape))
    return surface(*capsule, side, position, memory);
  if (const auto* cylinder = std::get_if<Cylinder>(&shape))
    return surface(*cylinder, side, position, memory);
  if (const auto* mesh = std::get_if<Mesh>(&shape))
    return mesh_surface_point(*mesh->surface, side, position, memory);
  if (const auto* grid = std::get_if<Grid>(&shape)) return surface(*grid, side, position, memory);
  return free_point(memory);
}

}  // namespace feltwire

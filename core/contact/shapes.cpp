#include "core/contact/shapes.hpp"

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/contact/mesh_contact.hpp"
#include "core/contact/round_proxy.hpp"
#include "core/geometry/distance_grid.hpp"
#include "core/geometry/mesh_surface.hpp"
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
  memory.feature = static_cast<std::uint32_t>(1 + feature);
  memory.normal = normal;
  return {point, normal, depth};
}

/// Free of a solid that has a far side: where it is now is where it comes from next.
SurfacePoint free_at(const Vec3& p, FeatureMemory& memory) {
  memory = {};
  memory.proxy = p;
  memory.tracked = true;
  return {};
}

/// On such a solid.
SurfacePoint held(const SurfacePoint& on, int feature, FeatureMemory& memory) {
  memory.side = 1;
  memory.proxy = on.point;
  memory.tracked = true;
  return contact(on.point, on.normal, on.depth, feature, memory);
}

/// Who is farther `off` a solid than the way that he came cannot have been in it.
bool cannot_have_met(double off, const Vec3& way) {
  return off > 0.0 && way.squaredNorm() < off * off;
}

SurfacePoint surface(const Plane&, Side side, const Vec3& p, FeatureMemory& memory) {
  const double up = side == Side::outside ? 1.0 : -1.0;
  if (!(up * p.z() < 0.0)) return free_point(memory);
  return contact(Vec3(p.x(), p.y(), 0.0), Vec3(0.0, 0.0, up), -up * p.z(), 0, memory);
}

/// A hollow at `radius` round `core`, the nearest point of the shape's core (centre, axis).
SurfacePoint hollow_surface(const Vec3& p, const Vec3& core, double radius, FeatureMemory& memory) {
  const Vec3 offset = p - core;
  const double distance = length(offset);
  if (!(distance > radius)) return free_point(memory);
  const Vec3 outward = direction(offset);
  return contact(core + radius * outward, -outward, std::abs(radius - distance), 0, memory);
}

/// Where the proxy with this normal holds a hand that has gone on from memory.proxy to p.
SurfacePoint held_on_round(const RoundSolid& solid, const Vec3& p, const Vec3& normal,
                           FeatureMemory& memory) {
  const Vec3 core = solid.core(p), offset = p - core;
  const double distance = length(offset);
  SurfacePoint on;
  if (normal == direction(offset)) {
    if (!(distance < solid.radius)) return free_at(p, memory);
    on = {core + solid.radius * normal, normal, std::abs(solid.radius - distance)};
  } else {
    if (!(distance < solid.radius) && !holds_behind(solid, normal, p)) return free_at(p, memory);
    on.point = solid.core_of(normal, p) + solid.radius * normal;
    const Polar<double> back = polar(Vec3(on.point - p));
    on.normal = back.length > 0.0 ? back.direction : normal;
    on.depth = back.length;
  }
  memory = {};
  memory.feature = 1;
  memory.side = 1;
  memory.normal = normal;
  memory.proxy = p;
  memory.tracked = true;
  return on;
}

/// `undefined` is the outward direction to take when p lies on the core itself.
SurfacePoint round_from_outside(const RoundSolid& solid, const Vec3& p, const Vec3& undefined,
                                FeatureMemory& memory) {
  const Vec3 offset = p - solid.core(p);
  const double off = length(offset) - solid.radius;
  Vec3 normal = direction(offset);
  if (normal.isZero(0.0)) normal = undefined;
  if (memory.feature != 0) {
    normal = round_normal(solid, memory.proxy, p, memory.normal);
  } else {
    Span in;
    if (memory.tracked && !cannot_have_met(off, p - memory.proxy))
      in = within(solid, memory.proxy, p - memory.proxy);
    if (in.in < in.out) {
      const Vec3 entry = memory.proxy + in.in * (p - memory.proxy);
      const Vec3 outward = direction(Vec3(entry - solid.core(entry)));
      if (!outward.isZero(0.0)) normal = round_normal(solid, entry, p, outward);
    } else if (!(off < 0.0)) {
      return free_at(p, memory);
    }
  }
  return held_on_round(solid, p, normal, memory);
}

SurfacePoint surface(const Sphere& sphere, Side side, const Vec3& p, FeatureMemory& memory) {
  if (side == Side::inside) return hollow_surface(p, Vec3::Zero(), sphere.radius, memory);
  return round_from_outside({sphere.radius, 0.0}, p, memory.normal, memory);
}

SurfacePoint surface(const Capsule& capsule, Side side, const Vec3& p, FeatureMemory& memory) {
  const double h = capsule.half_length;
  if (side == Side::inside)
    return hollow_surface(p, Vec3(0.0, 0.0, std::clamp(p.z(), -h, h)), capsule.radius, memory);
  // On the axis every direction across it is as near; beyond its ends so is the half sphere.
  Vec3 undefined = memory.normal;
  undefined.z() = std::clamp(undefined.z(), p.z() <= -h ? -1.0 : 0.0, p.z() >= h ? 1.0 : 0.0);
  undefined = undefined.isZero(0.0) ? Vec3::UnitX() : direction(undefined);
  return round_from_outside({capsule.radius, h}, p, undefined, memory);
}

/// The face by which the way from a free point goes in; -1: it does not.
int box_entry(const Vec3& h, const Vec3& from, const Vec3& to) {
  double in = 0.0, out = 1.0;
  int entered = -1;
  for (int face = 0; face < kBoxFaces; ++face) {
    const int axis = face / 2;
    const double sign = face % 2 == 0 ? 1.0 : -1.0;
    const double before = sign * from[axis] - h[axis], after = sign * to[axis] - h[axis];
    if (before >= 0.0 && after >= 0.0) return -1;
    if (before >= 0.0) {
      const double part = before / (before - after);
      if (entered >= 0 && !(part > in)) continue;
      in = part;
      entered = face;
    } else if (after >= 0.0) {
      out = std::min(out, before / (before - after));
    }
  }
  return in < out ? entered : -1;
}

SurfacePoint box_from_outside(const Vec3& h, const Vec3& p, FeatureMemory& memory) {
  // A convex solid holds the whole way between two points in it, so whoever is still inside has
  // crossed no other face since he entered. Only for who was never seen before is it the nearest.
  int face = static_cast<int>(memory.feature) - 1;
  if (face < 0 || face >= kBoxFaces) {
    face = memory.tracked ? box_entry(h, memory.proxy, p) : -1;
    if (face < 0) {
      const Vec3 deep = h - p.cwiseAbs();
      if (!(deep.x() > 0.0 && deep.y() > 0.0 && deep.z() > 0.0)) return free_at(p, memory);
      Eigen::Index axis;
      deep.minCoeff(&axis);
      face = 2 * static_cast<int>(axis) + (p[axis] < 0.0 ? 1 : 0);
    }
  }
  const int axis = face / 2;
  const double sign = face % 2 == 0 ? 1.0 : -1.0;
  const double depth = h[axis] - sign * p[axis];
  for (int other = 0; other < 3; ++other)
    if (other != axis && !(std::abs(p[other]) < h[other])) return free_at(p, memory);
  if (!(depth > 0.0)) return free_at(p, memory);
  Vec3 point = p;
  point[axis] = sign * h[axis];
  return held({point, sign * Vec3::Unit(axis), depth}, face, memory);
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

/// Seen from within, the cylinder is convex for the proxy, as the box is.
SurfacePoint cylinder_from_inside(const Cylinder& cylinder, const Vec3& p, FeatureMemory& memory) {
  const double h = cylinder.half_length;
  const Vec3 across(p.x(), p.y(), 0.0);
  const double beyond_side = std::max(0.0, length(across) - cylinder.radius);
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

/// The same of a cylinder.
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

SurfacePoint surface(const Cylinder& cylinder, Side side, const Vec3& p, FeatureMemory& memory) {
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
    return held({point, sign * Vec3::UnitZ(), depth}, feature, memory);
  }
  return cylinder_side(cylinder, p, memory);
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

bool follows_way(const Shape& shape, Side side) noexcept {
  if (std::holds_alternative<Mesh>(shape)) return true;
  return side == Side::outside && !std::holds_alternative<Plane>(shape) &&
         !std::holds_alternative<Grid>(shape);
}

Vec3 origin_of(const Shape& shape) noexcept {
  const auto* mesh = std::get_if<Mesh>(&shape);
  return mesh != nullptr ? mesh->surface->mesh().origin() : Vec3(Vec3::Zero());
}

void approach_from(const Shape& shape, const Vec3& position, FeatureMemory& memory) noexcept {
  memory = {};
  memory.proxy = position - origin_of(shape);
  memory.tracked = true;
}

}  // namespace feltwire

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/geometry/solid_proxy.hpp"

namespace feltwire {
namespace {

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
  return held_on({point, sign * Vec3::Unit(axis), depth}, face, memory);
}

/// Seen from within, the box is convex for the proxy: it is the clamped point, on one face, an edge
/// or a corner, and the force runs along the line between.
SurfacePoint box_from_inside(const Vec3& h, const Vec3& p, FeatureMemory& memory) {
  const Vec3 point = p.cwiseMax(-h).cwiseMin(h);
  const Vec3 beyond = p - point;
  const double depth = length(beyond);
  if (!(depth > 0.0)) return no_contact(memory);
  Eigen::Index axis;
  beyond.cwiseAbs().maxCoeff(&axis);
  const int face = 2 * static_cast<int>(axis) + (beyond[axis] < 0.0 ? 1 : 0);
  return stand_on(point, -direction(beyond), depth, face, memory);
}

}  // namespace

SurfacePoint surface_point(const Box& box, Side side, const Vec3& p,
                           FeatureMemory& memory) noexcept {
  return side == Side::outside ? box_from_outside(box.half_extents, p, memory)
                               : box_from_inside(box.half_extents, p, memory);
}

}  // namespace feltwire

#pragma once
// Bodies that a robot's target stays out of.

#include "core/base/types.hpp"

namespace feltwire {

/// A plane that a target stays in front of: normal . x >= distance.
struct WorkspaceWall {
  Vec3 normal = Vec3::UnitZ();  // unit, towards the side where the target may be
  double distance = 0.0;        // [m] of the plane from the origin, along the normal
  /// [m] from the wall to a point; below 0: the point is behind it.
  double clearance(const Vec3& point) const noexcept { return normal.dot(point) - distance; }
};

/// All places within `radius` of a box, in the robot's frame: a box with round edges. A box without
/// extent is a ball, and one with one extent is a capsule.
struct KeepOutBody {
  static constexpr double kLeastRadius = 1e-3;  // [m] a sharper edge would be felt as a jump

  Pose pose;                 // of the middle of the box
  Vec3 half = Vec3::Zero();  // [m] half the extents of the box, >= 0
  double radius = 0.01;      // [m] >= kLeastRadius

  /// Whether all numbers are finite and within the bounds above and `farthest` [m], and the
  /// orientation is a unit quaternion.
  bool valid(double farthest) const noexcept;

  /// Returns the wall whose clearance at `point` is the signed distance f of that point from the
  /// body, and whose normal is the gradient of f there. f is convex, so at every place x
  ///   f(x) >= f(point) + normal . (x - point):
  /// of a point outside, the whole body is behind the wall; from a point inside, no movement along
  /// the normal leads deeper.
  WorkspaceWall wall_at(const Vec3& point) const noexcept;
};

}  // namespace feltwire

#pragma once
// The motion of the objects in a step of a tool with a body.

#include <span>

#include "core/point_shell/shell_contact.hpp"

namespace feltwire {

/// The movement of an object since the step before, and the share of its force that is felt.
struct ObjectMotion {
  Vec3 linear = Vec3::Zero();   // [m] of the object's origin
  Vec3 angular = Vec3::Zero();  // [rad]
  double share = 1.0;
};

/// Object `index` in the step of a tool at a pose. `motions`: one for each object; empty: all are
/// static.
inline ObjectInStep in_step(std::size_t index, const Object& object,
                            std::span<const ObjectMotion> motions, const Pose& tool) noexcept {
  ObjectInStep in{.index = static_cast<std::uint32_t>(index)};
  if (index >= motions.size()) return in;
  const ObjectMotion& motion = motions[index];
  const Vec3 arm = tool.position - object.pose.position;
  in.share = motion.share;
  in.carried << motion.linear + motion.angular.cross(arm), motion.angular;
  return in;
}

/// A generalised vector or matrix (translation, then rotation) in a frame turned by `rotation`.
inline Vec6 turned_by(const Mat3& rotation, const Vec6& v) noexcept {
  Vec6 result;
  result << rotation * v.head<3>(), rotation * v.tail<3>();
  return result;
}
inline Mat6 turned_by(const Mat3& rotation, const Mat6& m) noexcept {
  Mat6 result;
  for (const Eigen::Index row : {0, 3})
    for (const Eigen::Index column : {0, 3})
      result.block<3, 3>(row, column) =
          rotation * m.block<3, 3>(row, column) * rotation.transpose();
  return result;
}

}  // namespace feltwire

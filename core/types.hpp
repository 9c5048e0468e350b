#pragma once
// The values that travel through feltwire. SI units; vectors are in the world frame unless a name
// says otherwise.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace feltwire {

using Vec3 = Eigen::Vector3d;
using Quaternion = Eigen::Quaterniond;

/// Pose of a tool or an object in the world frame.
struct Pose {
  Vec3 position = Vec3::Zero();  // [m]
  Quaternion orientation =
      Quaternion::Identity();  // unit; rotates the own frame into the world frame
};

/// What acts on the hand, kept in the parts that the energy bound needs apart.
/// Sign: f, the force that the environment puts ON THE HAND (bounding.md); the paper's F is -f.
struct Command {
  Vec3 elastic = Vec3::Zero();     // [N] resultant of the penalty / proxy forces
  Vec3 frictional = Vec3::Zero();  // [N] everything else: friction, contact damping, viscosity
  Vec3 torque = Vec3::Zero();      // [N m]

  Vec3 force() const { return elastic + frictional; }  // [N]
  bool finite() const {
    return elastic.allFinite() && frictional.allFinite() && torque.allFinite();
  }
  friend Command operator*(double scale, const Command& c) {
    return {scale * c.elastic, scale * c.frictional, scale * c.torque};
  }
};

/// The state of the tool point that contact is computed from.
struct Tool {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 velocity = Vec3::Zero();  // [m/s]
};

/// Rotation vector of `to * from^-1` in the world frame [rad], the short way round (norm <= pi).
/// Neither quaternion has to be quite unit; q and -q are the same orientation. Anything not finite,
/// and a quaternion of norm zero, gives zero.
Vec3 rotation_between(const Quaternion& from, const Quaternion& to);

}  // namespace feltwire

#pragma once
// The basic values: vectors, poses, commands. SI units. Vectors are in the world frame unless a
// name says otherwise.

#include <Eigen/Core>
#include <Eigen/Geometry>

namespace feltwire {

template <class Real>
using Vector3 = Eigen::Matrix<Real, 3, 1>;
template <class Real>
using Matrix3 = Eigen::Matrix<Real, 3, 3>;
using Vec3 = Vector3<double>;
using Mat3 = Matrix3<double>;
using Quaternion = Eigen::Quaterniond;

/// Pose of a tool or an object in the world frame.
struct Pose {
  Vec3 position = Vec3::Zero();  // [m]
  Quaternion orientation =
      Quaternion::Identity();  // unit; rotates from the object's frame to the world frame
};

/// A force and a torque on the hand. The elastic and the frictional part are separate, because the
/// energy bound treats them differently. Sign: f, the force that the environment puts ON THE HAND
/// (docs/bounding.md); the paper's F is -f.
template <class Real>
struct BasicCommand {
  Vector3<Real> elastic = Vector3<Real>::Zero();  // [N] resultant of the penalty / proxy forces
  Vector3<Real> frictional =
      Vector3<Real>::Zero();  // [N] everything else: friction, contact damping, viscosity, guides
  Vector3<Real> torque = Vector3<Real>::Zero();  // [N m]

  Vector3<Real> force() const { return elastic + frictional; }  // [N]
  bool finite() const {
    return elastic.allFinite() && frictional.allFinite() && torque.allFinite();
  }
  template <class Other>
  BasicCommand<Other> cast() const {
    return {elastic.template cast<Other>(), frictional.template cast<Other>(),
            torque.template cast<Other>()};
  }
  friend BasicCommand operator*(Real scale, const BasicCommand& c) {
    return {scale * c.elastic, scale * c.frictional, scale * c.torque};
  }
  friend bool operator==(const BasicCommand&, const BasicCommand&) = default;
};
using Command = BasicCommand<double>;

/// The state of the tool point that contact is computed from.
struct Tool {
  Vec3 position = Vec3::Zero();  // [m]
  Vec3 velocity = Vec3::Zero();  // [m/s]
};

/// The rotation vector of `to * from^-1` in the world frame [rad], the short way round (norm <=
/// pi). The quaternions need not be exactly unit; q and -q are the same orientation. Returns zero
/// if a number is not finite or a quaternion has norm zero.
Vec3 rotation_between(const Quaternion& from, const Quaternion& to);

/// The smallest turn that takes the direction `from` to the direction `to`. Neither need be unit.
Quaternion turn_to(const Vec3& from, const Vec3& to);

/// The orientation `from` turned further by the rotation vector `by` [rad], world frame: the
/// inverse of rotation_between() for |by| < pi. Unit; `from` itself where `by` is zero.
Quaternion turned(const Quaternion& from, const Vec3& by);

}  // namespace feltwire

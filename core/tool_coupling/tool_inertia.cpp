#include "core/tool_coupling/tool_inertia.hpp"

#include <Eigen/Cholesky>
#include <Eigen/LU>
#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

Mat3 cross_matrix(const Vec3& v) {
  Mat3 m;
  m << 0.0, -v.z(), v.y(), v.z(), 0.0, -v.x(), -v.y(), v.x(), 0.0;
  return m;
}

Mat3 turned_by(const Quaternion& orientation, const Mat3& own) {
  const Mat3 turn = orientation.toRotationMatrix();
  return turn * own * turn.transpose();
}

/// Returns the inverse of the left Jacobian of the exponential map (Chirikjian 2012, Stochastic
/// Models, Information Theory, and Lie Groups 2, 10.86). It maps a further small rotation in the
/// world frame to the change of the rotation vector `turn`. Precondition: |turn| <= pi.
Mat3 inverse_left_jacobian(const Vec3& turn) {
  constexpr double kSmall = 1e-4;  // Below this squared angle, the series is exact.
  const double squared = turn.squaredNorm();
  double factor = 1.0 / 12.0 + squared / 720.0;
  if (squared > kSmall) {
    const double half = 0.5 * std::sqrt(squared);
    factor = (1.0 - half / std::tan(half)) / squared;
  }
  const Mat3 k = cross_matrix(turn);
  return Mat3::Identity() - 0.5 * k + factor * k * k;
}

Vec3 rotated(const Vec3& by, const Vec3& v) {
  const Polar<double> angle = polar(by);
  if (!(angle.length > 0.0)) return v;
  return Eigen::AngleAxisd(angle.length, angle.direction) * v;
}

}  // namespace

double kinetic_energy(const ToolInertia& tool, const Quaternion& orientation,
                      const ToolVelocity& velocity) noexcept {
  const Vec3 own = orientation.conjugate() * velocity.angular;
  return 0.5 * (tool.mass * velocity.linear.squaredNorm() + own.dot(tool.inertia * own));
}

Vec3 center_of_mass(const ToolInertia& tool, const Pose& pose) noexcept {
  return pose.position + pose.orientation * tool.center;
}

Vec3 free_turn(const Mat3& inertia, const Vec3& angular, double elapsed) noexcept {
  constexpr int kMost = 16;
  constexpr double kClose = 1e-30;  // tolerance, as a share of the squared velocity
  if (angular.isZero(0.0)) return angular;
  const Vec3 momentum = inertia * angular;
  const Eigen::LLT<Mat3> factors(inertia);
  Vec3 mean = angular;
  for (int i = 0; i < kMost; ++i) {
    const Vec3 next = 0.5 * (angular + factors.solve(rotated(-elapsed * mean, momentum)));
    const double change = (next - mean).squaredNorm();
    mean = next;
    if (!(change > kClose * angular.squaredNorm())) break;
  }
  const double had = angular.dot(momentum), has = mean.dot(inertia * mean);
  // Rounding errors or a missing convergence have increased the energy. Reduce it to its start
  // value.
  if (has > had) mean *= std::sqrt(had / has);
  return mean;
}

InertialStep::InertialStep(const ToolInertia& tool, const Pose& pose, const ToolVelocity& velocity,
                           double elapsed, double share) noexcept
    : tool_(tool),
      start_(pose),
      before_(velocity),
      elapsed_(elapsed),
      share_(share),
      start_center_(center_of_mass(tool, pose)),
      center_(start_center_ + share * elapsed * velocity.linear) {
  const Vec3 mean =
      free_turn(tool.inertia, pose.orientation.conjugate() * velocity.angular, elapsed);
  orientation_ = turned(pose.orientation, pose.orientation * (share * elapsed * mean));
  inertia_ = turned_by(orientation_, tool.inertia);
}

InertialStep::Away InertialStep::away(const Pose& pose) const noexcept {
  return {center_of_mass(tool_, pose) - center_, rotation_between(orientation_, pose.orientation)};
}

double InertialStep::weight_energy(const Pose& pose) const noexcept {
  return -tool_.mass * tool_.gravity.dot(center_of_mass(tool_, pose) - start_center_);
}

double InertialStep::energy(const Pose& pose) const noexcept {
  const double time = share_ * elapsed_;
  const Away off = away(pose);
  return 0.5 / (time * time) *
             (tool_.mass * off.center.squaredNorm() + off.turn.dot(inertia_ * off.turn)) +
         weight_energy(pose);
}

InertialStep::Term InertialStep::term(const Pose& pose) const noexcept {
  const double time = share_ * elapsed_, per_square = 1.0 / (time * time);
  const Away off = away(pose);
  const Vec3 arm = pose.orientation * tool_.center;
  const Vec3 force = tool_.mass * (tool_.gravity - per_square * off.center);
  const Mat3 turning = inverse_left_jacobian(off.turn), across = cross_matrix(arm);
  Term term;
  term.wrench << force,
      arm.cross(force) - per_square * (turning.transpose() * (inertia_ * off.turn));
  const double mass = per_square * tool_.mass;
  term.stiffness.topLeftCorner<3, 3>().diagonal().setConstant(mass);
  term.stiffness.topRightCorner<3, 3>() = -mass * across;
  term.stiffness.bottomLeftCorner<3, 3>() = mass * across;
  term.stiffness.bottomRightCorner<3, 3>() =
      per_square * (turning.transpose() * inertia_ * turning) - mass * across * across;
  return term;
}

Pose InertialStep::whole(const Pose& found) const noexcept {
  if (share_ == 1.0) return found;
  const Vec3 on = center_of_mass(tool_, found) - start_center_;
  Pose pose;
  pose.orientation =
      turned(found.orientation, rotation_between(start_.orientation, found.orientation));
  pose.position = start_center_ + on / share_ - pose.orientation * tool_.center;
  return pose;
}

ToolVelocity InertialStep::velocity(const Pose& found) const noexcept {
  const double time = share_ * elapsed_;
  const Away off = away(found);
  const Vec3 torque = inverse_left_jacobian(off.turn).transpose() * (inertia_ * off.turn) / time;
  const Vec3 momentum =
      turned_by(start_.orientation, tool_.inertia) * before_.angular + torque / share_;
  const Quaternion end = whole(found).orientation;
  const Vec3 own = tool_.inertia.llt().solve(end.conjugate() * momentum);
  return {before_.linear + off.center / (time * share_), end * own};
}

}  // namespace feltwire

#include "core/teleoperation/keep_out_body.hpp"

#include <cmath>

namespace feltwire {
namespace {

Vec3 sides(const Vec3& at) noexcept {
  return at.unaryExpr([](double x) { return std::copysign(1.0, x); });
}

}  // namespace

bool KeepOutBody::valid(double farthest) const noexcept {
  constexpr double kUnit = 1e-6;
  // All these comparisons are false for NaN.
  return pose.position.cwiseAbs().maxCoeff() <= farthest && half.minCoeff() >= 0.0 &&
         half.maxCoeff() <= farthest && radius >= kLeastRadius && radius <= farthest &&
         std::abs(pose.orientation.squaredNorm() - 1.0) <= kUnit && pose.position.allFinite() &&
         half.allFinite();
}

WorkspaceWall KeepOutBody::wall_at(const Vec3& point) const noexcept {
  const Quaternion& turn = pose.orientation;
  const Vec3 at = turn.conjugate() * (point - pose.position);
  const Vec3 beyond = at.cwiseAbs() - half;
  const Vec3 outside = beyond.cwiseMax(0.0);
  const double length = outside.norm();
  Vec3 normal = Vec3::Zero();
  double distance = length - radius;
  if (length > 0.0) {
    normal = (outside / length).cwiseProduct(sides(at));
  } else {
    Eigen::Index axis = 0;
    distance = beyond.maxCoeff(&axis) - radius;
    normal[axis] = sides(at)[axis];
  }
  const Vec3 along = (turn * normal).normalized();
  return {along, along.dot(point) - distance};
}

}  // namespace feltwire

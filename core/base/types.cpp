#include "core/base/types.hpp"

#include <cmath>

#include "core/base/numeric.hpp"

namespace feltwire {

Vec3 rotation_between(const Quaternion& from, const Quaternion& to) {
  // `to * conj(from)` is the unit rotation times the factor |to||from|. The angle depends only on
  // the ratio of the quaternion's parts, so this factor does not matter.
  const Quaternion difference = to * from.conjugate();
  const double sine = difference.vec().norm();
  if (!(sine > 0.0) || !std::isfinite(sine) || !std::isfinite(difference.w())) return Vec3::Zero();
  const double angle = 2.0 * std::atan2(sine, std::abs(difference.w()));
  return (difference.w() < 0.0 ? -angle : angle) / sine * difference.vec();
}

Quaternion turn_to(const Vec3& from, const Vec3& to) {
  return Quaternion::FromTwoVectors(from, to);
}

Quaternion turned(const Quaternion& from, const Vec3& by) {
  const Polar<double> angle = polar(by);
  if (!(angle.length > 0.0)) return from;
  return (Quaternion(Eigen::AngleAxisd(angle.length, angle.direction)) * from).normalized();
}

}  // namespace feltwire

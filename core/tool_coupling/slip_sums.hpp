#pragma once
// The slip that a motion causes in a patch of contact points.

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/tool_coupling/tool_contact.hpp"

namespace feltwire {

/// The geometry of a patch: sums over its points, weighted by their load.
struct SlipSums {
  double weight = 0.0;
  Vec3 arm = Vec3::Zero(), normal = Vec3::Zero();  // [m] from the tool's origin; unit
  Mat3 arms = Mat3::Zero();                        // of arm arm^T, lower half

  void add(double load, const Vec3& arm_of, const Vec3& normal_of) noexcept {
    weight += load;
    arm += load * arm_of;
    normal += load * normal_of;
    arms += load * arm_of * arm_of.transpose();
  }

  SlipSums& operator+=(const SlipSums& more) noexcept {
    weight += more.weight;
    arm += more.arm;
    normal += more.normal;
    arms += more.arms;
    return *this;
  }

  /// The slip of a motion v, w: that of the centre c along the surface, v + w x c less its part
  /// along the mean normal n, and that of the points about n. Rocking on the surface is not slip.
  Mat6 slip() const noexcept {
    const Vec3 c = arm / weight, n = direction(normal);
    const Mat3 across = Mat3::Identity() - n * n.transpose();
    Mat3 cross;  // c x
    cross << 0.0, -c.z(), c.y(), c.z(), 0.0, -c.x(), -c.y(), c.x(), 0.0;
    const Mat3 squares = Mat3(arms.selfadjointView<Eigen::Lower>()) / weight - c * c.transpose();
    const double about = std::max(0.0, squares.trace() - n.dot(squares * n));
    Mat6 m;
    m.topLeftCorner<3, 3>() = across;
    m.topRightCorner<3, 3>() = -across * cross;
    m.bottomLeftCorner<3, 3>() = cross * across;
    m.bottomRightCorner<3, 3>() = about * n * n.transpose() - cross * across * cross;
    return m;
  }
};

}  // namespace feltwire

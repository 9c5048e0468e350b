#pragma once
// Maps the place of a hand to the place of a robot.

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/base/types.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/workspace.hpp"

namespace feltwire {

/// The hand's movement since it engaged, times a scale, is the target's movement since then:
///   x_t = x_t0 + s (x_h - x_h0),     q_t = q_h q_h0^-1 q_t0
/// The first target is then equal to the target that the robot has, for any poses and any scale:
/// exactly in position, to rounding in orientation. Turning is never scaled. Where the robot's tool
/// is turned as the hand is (Alignment), align() takes q_h0^-1 q_t0 to the offset of both.
///
/// The hand's force is the robot's times a scale, F_h = f F_r. What else is the robot's is
/// converted to the hand: places by this offset, speeds by 1 / s, stiffness by f s, energy by f /
/// s, as F dx is.
class ClutchOffset {
 public:
  /// `scale` s > 0 [m of the robot per m of the hand], `force_scale` f > 0 [N at the hand per N at
  /// the robot].
  explicit ClutchOffset(double scale, double force_scale = 1.0)
      : scale_(scale), force_scale_(force_scale) {}

  /// From now on `hand`, less its offset, corresponds to `target`.
  void engage(const Pose& hand, const Pose& target) noexcept {
    hand_ = hand;
    target_ = target;
    turn_ = hand.orientation.conjugate() * target.orientation;
  }

  /// Precondition: the orientation is unit.
  Pose target(const Pose& hand) const noexcept {
    return {target_.position + scale_ * (hand.position - hand_.position),
            (hand.orientation * turn_).normalized()};
  }

  /// Moves every later target by `movement` [m]. So a target that a limit moved corresponds to the
  /// hand's present place, and a hand that comes back moves the robot at once.
  void shift(const Vec3& movement) noexcept { target_.position += movement; }

  /// Later targets are turned towards those of an aligned hand, by `angle` [rad] >= 0 at most.
  /// `offset` as in Alignment, unit.
  void align(const Quaternion& offset, double angle) noexcept {
    const Polar<double> left = polar(rotation_between(turn_, offset));
    if (left.length > 0.0) turn_ = turned(turn_, std::min(angle, left.length) * left.direction);
  }

  /// Returns a contact of the robot, in the hand's frame.
  RemoteContact at_hand(const RemoteContact& contact) const noexcept {
    RemoteContact seen = contact;
    seen.point = hand_.position + (contact.point - target_.position) / scale_;
    seen.velocity = contact.velocity / scale_;
    seen.stiffness = contact.stiffness * force_scale_ * scale_;
    return seen;
  }
  WorkspaceWall at_hand(const WorkspaceWall& wall) const noexcept {
    return {wall.normal,
            wall.normal.dot(hand_.position) - wall.clearance(target_.position) / scale_};
  }
  EnergyCounters at_hand(const EnergyCounters& robot) const noexcept {
    const double share = force_scale_ / scale_;
    return {share * robot.given, share * robot.taken, share * robot.pushed};
  }
  /// Returns the energy [J] that a hand paid, in the robot's units.
  double at_robot(double hand_work) const noexcept { return scale_ / force_scale_ * hand_work; }

 private:
  double scale_, force_scale_;
  Pose hand_, target_;                        // the poses when the hand engaged
  Quaternion turn_ = Quaternion::Identity();  // from the hand's orientation to the target's
};

}  // namespace feltwire

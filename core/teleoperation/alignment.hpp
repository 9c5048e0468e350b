#pragma once
// A robot's tool that is turned as the hand is.

#include "core/base/types.hpp"

namespace feltwire {

/// The hand's orientation means one of the robot's tool, at all times:
///   q_t = q_h q_offset
/// So a hand that turned while its switch was released must turn back before it engages, to within
/// the gate. What is left of the angle is given back later (ClutchOffset::align), so the first
/// target is equal to the one that the robot has.
struct Alignment {
  static constexpr double kLargestGate = 3.0;  // [rad]
  /// Share of each turn of an engaged hand that reduces the remaining offset.
  static constexpr double kGivenBack = 0.5;

  Quaternion offset = Quaternion::Identity();  // unit: of the robot's tool, seen from the hand's
  double gate = 0.26;                          // [rad] > 0 largest angle at which a hand engages

  /// The rotation vector [rad] by which the hand has to turn until the target `robot` corresponds
  /// to it; in the hand's frame, norm <= pi. The orientations are unit.
  Vec3 missing(const Quaternion& hand, const Quaternion& robot) const {
    return rotation_between(hand * offset, robot);
  }
};

}  // namespace feltwire

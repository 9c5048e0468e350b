#pragma once
// Tells a movement of a hand from a jump of the reading.

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/types.hpp"
#include "core/device/device_spec.hpp"

namespace feltwire {

/// The fastest that a handle moves, or turns: for rotation read rad. docs/devices.md, "A reading
/// that jumps", says where the numbers come from.
struct MovementBounds {
  double fastest = 0.0;  // [m/s] no hand moves faster
  double knock = 0.0;    // [m/s] the largest speed that a blow gives at once
  double pull = 0.0;     // [m/s^2] the largest acceleration that lasts
  double error = 0.0;    // [m] by which a displacement between two readings may be wrong
};

/// For the position that a device of this specification shows in the scene, where `scale` metres
/// are one metre of the handle.
inline MovementBounds position_bounds(const DeviceSpec& spec, double scale = 1.0) noexcept {
  constexpr double kFastest = 10.0, kKnock = 2.0;  // [m/s] of the handle
  constexpr double kPull = 400.0;                  // [m/s^2] of the handle
  const double light =
      spec.least_mass > 0.0 ? (spec.max_force + spec.hand_force) / spec.least_mass : 0.0;
  return {.fastest = scale * kFastest,
          .knock = scale * kKnock,
          .pull = std::max(scale * kPull, light),
          .error = std::sqrt(3.0) * spec.position_resolution};
}

/// For its orientation. One that only senses it may tell it seldom, by radio.
inline MovementBounds rotation_bounds(const DeviceSpec& spec) noexcept {
  constexpr double kFastest = 100.0, kKnock = 20.0;  // [rad/s]
  constexpr double kPull = 1e4;                      // [rad/s^2]
  constexpr double kSeldom = 0.1;                    // [rad]
  const double light =
      spec.rotation.least_inertia > 0.0
          ? (spec.max_torque + spec.rotation.hand_torque) / spec.rotation.least_inertia
          : 0.0;
  return {.fastest = kFastest,
          .knock = kKnock,
          .pull = std::max(kPull, light),
          .error = std::sqrt(3.0) * spec.rotation.resolution +
                   (spec.rotation_actuated > 0 ? 0.0 : kSeldom)};
}

/// Judges one movement after another. With v = |dx| / h, and v0 the larger of the speeds of the two
/// movements before, a hand made dx in the time h if
///
///   v - 2 e / h <= fastest     and     v - v0 - pull h - 2 e / h <= knock
///
/// So a hand may be stopped at once, and be thrown back by a stop as fast as it came: within one
/// movement, which then hardly shows a speed. What only a knock explains, because the speed along
/// the new direction rose by more than pull h, counts together if it is against the direction of
/// the last such knock: three knocks to and fro may follow each other, and another in each
/// kBetweenKnocks. So an encoder whose bit flickers is no hand that shakes.
///
/// A plain value: no function allocates, throws or reads a clock.
class PossibleMovement {
 public:
  static constexpr double kBetweenKnocks = 0.05;  // [s]

  explicit PossibleMovement(const MovementBounds& bounds) : bounds_(bounds), left_(most()) {}

  /// Whether a hand can have moved by `displacement` [m] in `time` [s] > 0, where it was at rest
  /// before the first one. False for one that is not finite. After false it begins anew.
  bool made(const Vec3& displacement, double time) noexcept {
    const bool possible = judge(displacement, time);
    if (!possible) forget();
    return possible;
  }
  /// The last movement is not known: the next one begins at rest.
  void forget() noexcept {
    velocity_.setZero();
    speed_before_ = 0.0;
  }

 private:
  bool judge(const Vec3& displacement, double time) noexcept {
    const double way = displacement.norm();
    const double speed = (way - 2.0 * bounds_.error) / time;
    if (!(speed <= bounds_.fastest)) return false;
    const double pulled = bounds_.pull * time;
    const double before = velocity_.norm();
    if (speed - std::max(before, speed_before_) - pulled > bounds_.knock) return false;
    left_ = std::min(most(), left_ + bounds_.knock * time / kBetweenKnocks);
    const double carried = way > 0.0 ? std::max(0.0, velocity_.dot(displacement) / way) : 0.0;
    if (const double knock = speed - carried - pulled; knock > 0.0) {
      if (displacement.dot(knock_) < 0.0) left_ -= knock;
      knock_ = displacement;
      if (left_ < 0.0) return false;
    }
    velocity_ = displacement / time;
    speed_before_ = before;
    return true;
  }
  double most() const noexcept { return 3.0 * bounds_.knock; }

  MovementBounds bounds_;
  Vec3 velocity_ = Vec3::Zero();  // [m/s] of the last movement
  double speed_before_ = 0.0;     // [m/s] of the one before it
  Vec3 knock_ = Vec3::Zero();     // [m] the last movement that only a knock explains
  double left_;                   // [m/s] of knocks to and fro
};

}  // namespace feltwire

#pragma once
// Limits how fast a hand may move and still act on moving objects, and how much of its force they
// get.

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/base/types.hpp"

namespace feltwire {

/// Limits of what one hand does to moving objects. Infinity switches a limit off.
struct HandLimits {
  static constexpr double kOff = std::numeric_limits<double>::infinity();
  double force = kOff;  // [N] on all of them together: the sum of the magnitudes
  double speed = kOff;  // [m/s] of the fastest point of its tool, over kHandHold and longer
};

/// [m/s] No hand at a haptic device is faster: the devices of core/device/device_spec.cpp reach 1
/// to 2 m/s, an arm that swings freely some 5. A body that a hand hits bounces off with at most
/// twice the hand's speed, so one that no hand can hit faster stays far below World::kLargestSpeed.
inline constexpr double kFastestHand = 10.0;
/// [s] A network may hold samples back for this long and then deliver them at once. So a hand may
/// use the movement of this time in a single sample. It is the usual hold_time; after that the hand
/// has no force any more.
inline constexpr double kHandHold = 0.1;

/// Compares the movement of one hand with its speed limit. Time is the server's, in ticks of the
/// world. A client's own clock is not used, because with it a client could claim any speed.
class HandSpeedLimit {
 public:
  HandSpeedLimit() = default;
  HandSpeedLimit(double speed, double tick, double recovery) noexcept
      : speed_(speed), tick_(tick), recovery_(recovery), left_(speed * kHandHold) {}

  /// The hand has moved by `way` [m] since the previous sample; the world is at tick `now`. Returns
  /// false if that is too fast. The force between the hand and moving objects then begins again
  /// from zero.
  bool follow(double way, std::uint64_t now) noexcept {
    if (speed_ == HandLimits::kOff) return true;
    left_ = std::min(speed_ * kHandHold, left_ + speed_ * tick_ * static_cast<double>(now - seen_));
    seen_ = now;
    if (way <= left_) {
      left_ -= way;
      return true;
    }
    left_ = 0.0;
    slow_since_ = now;
    was_fast_ = true;
    return false;
  }
  /// The share of the force that is used: below 1 until `recovery` [s] after the hand was too fast,
  /// else 1.
  double trust(std::uint64_t now) const noexcept {
    if (!was_fast_) return 1.0;
    return std::min(1.0, tick_ * static_cast<double>(now - slow_since_) / recovery_);
  }

 private:
  double speed_ = HandLimits::kOff, tick_ = 0.0, recovery_ = 1.0;
  double left_ = 0.0;                        // [m] the movement that it may still use at once
  std::uint64_t seen_ = 0, slow_since_ = 0;  // [ticks]
  bool was_fast_ = false;
};

}  // namespace feltwire

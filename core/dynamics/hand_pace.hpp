#pragma once
// How fast a hand may be to what moves, and with how much of its force it is felt there.

#include <algorithm>
#include <cstdint>
#include <limits>

#include "core/base/types.hpp"

namespace feltwire {

/// What one hand may do to the moving objects; infinity switches each off.
struct HandLimits {
  static constexpr double kOff = std::numeric_limits<double>::infinity();
  double force = kOff;  // [N] on all of them together: the sum of the magnitudes
  double speed = kOff;  // [m/s] of the fastest point of its tool, over kHandHold and longer
};

/// [m/s] No hand at a haptic device is faster: the devices of core/device/device_spec.cpp reach 1
/// to 2 m/s, an arm that swings freely some 5. A body that a hand hits bounces off with at most
/// twice the hand's speed, so one that no hand can hit faster stays far below World::kLargestSpeed.
inline constexpr double kFastestHand = 10.0;
/// [s] A network may hold samples back for so long and let them go at once: within this time a hand
/// may go its way in one sample. It is the usual hold_time, after which a hand has let go.
inline constexpr double kHandHold = 0.1;

/// The way of one hand, held against its speed limit. What counts is the server's time, in ticks of
/// the world: what a client says of its own clock would let it be as fast as it likes.
class HandPace {
 public:
  HandPace() = default;
  HandPace(double speed, double tick, double recovery) noexcept
      : speed_(speed), tick_(tick), recovery_(recovery), left_(speed * kHandHold) {}

  /// The hand has gone so far [m] since the sample before, and the world is at tick `now`. False
  /// where that is too fast: the hand is then felt by what moves, and feels it, from nothing again.
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
  /// Share of its force: 1, less until `recovery` after it was too fast.
  double trust(std::uint64_t now) const noexcept {
    if (!was_fast_) return 1.0;
    return std::min(1.0, tick_ * static_cast<double>(now - slow_since_) / recovery_);
  }

 private:
  double speed_ = HandLimits::kOff, tick_ = 0.0, recovery_ = 1.0;
  double left_ = 0.0;                        // [m] that it may go at once
  std::uint64_t seen_ = 0, slow_since_ = 0;  // [ticks]
  bool was_fast_ = false;
};

}  // namespace feltwire

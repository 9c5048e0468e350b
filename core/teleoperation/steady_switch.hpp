#pragma once
// An enabling switch that flickers is no switch that a hand presses.

#include <array>
#include <cstdint>

#include "core/base/time.hpp"

namespace feltwire {

/// A press counts at once, unless it is one of more than kPresses within kWithin: then it counts
/// after it was held for kSteady. A release counts at once, always. So a switch that flickers, by a
/// broken contact or on purpose, engages a few times and then stays released. A value; it reads no
/// clock.
class SteadySwitch {
 public:
  static constexpr std::size_t kPresses = 4;
  static constexpr Nanoseconds kWithin = std::chrono::seconds(1);
  static constexpr Nanoseconds kSteady = std::chrono::milliseconds(500);

  /// The switch as it is at `now`, a monotonic time. Returns whether it counts as pressed.
  bool step(bool pressed, Nanoseconds now) noexcept {
    if (pressed && !pressed_) {
      Nanoseconds& oldest = pressed_at_[presses_ % kPresses];
      counts_ = presses_ < kPresses || now - oldest > kWithin;
      oldest = since_ = now;
      ++presses_;
    }
    pressed_ = pressed;
    counts_ = pressed && (counts_ || now - since_ >= kSteady);
    return counts_;
  }
  /// Whether it counted as pressed in the last step.
  bool pressed() const noexcept { return counts_; }

 private:
  std::array<Nanoseconds, kPresses> pressed_at_{};  // of the last presses
  std::uint64_t presses_ = 0;
  Nanoseconds since_{0};  // of the last one
  bool pressed_ = false, counts_ = false;
};

}  // namespace feltwire

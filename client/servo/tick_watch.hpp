#pragma once
// Detects from looks at a tick counter that a servo thread stands still.

#include <cstdint>
#include <optional>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Counts the time between two looks, but no more than kMostCounted intervals of it. So a watch
/// that is woken late, as on a loaded machine, is late only once. And a program that was stopped as
/// a whole, together with its watch, has time to tick again.
class TickWatch {
 public:
  static constexpr int kLooks =
      20;  // number of intervals in the time for which a force may be held without a tick
  static constexpr int kMostCounted = 10;
  static constexpr Nanoseconds kIdle =
      std::chrono::seconds(2);  // the same time if there is no force
  static constexpr Nanoseconds kGrace = std::chrono::seconds(1);

  enum class Verdict : std::uint8_t {
    ticks,
    stands_still,  // from now on, every time: release the device
    gone           // also for kGrace after that: do not wait for it any more
  };

  /// A force is held for at most `hold` without a tick.
  explicit TickWatch(Nanoseconds hold) : interval_(hold / kLooks) {}

  /// The time from a look to the next one. It is an interval, or less if the hold time is over
  /// before.
  Nanoseconds pause() const noexcept;
  /// `now`: a monotonic time. `ticks` so far; `pulls`: a force is on the hand.
  Verdict look(Nanoseconds now, std::uint64_t ticks, bool pulls) noexcept;

 private:
  /// [ns] that a force may be held after the look that saw the last tick. That tick came up to an
  /// interval before the look, and another interval is left to wake threads in.
  Nanoseconds most_pulling() const noexcept { return (kLooks - 2) * interval_; }

  Nanoseconds interval_;
  std::optional<Nanoseconds> looked_;  // the time of the last look
  std::uint64_t ticks_ = 0;
  Nanoseconds still_{0}, pulling_{0}, since_{0};
  bool stands_still_ = false;
};

}  // namespace feltwire

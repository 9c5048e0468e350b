#pragma once
// Detects from samples of a tick counter that a servo thread stands still. It uses no clock: a
// program that was stopped as a whole, together with its watch, does not count.

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

class TickWatch {
 public:
  static constexpr int kLooks =
      10;  // number of samples in the time for which a force may be held without a tick
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

  /// The time between two samples.
  Nanoseconds interval() const { return interval_; }
  /// `ticks` so far; `pulls`: a force is on the hand.
  Verdict look(std::uint64_t ticks, bool pulls) noexcept;

 private:
  Nanoseconds interval_;
  std::uint64_t ticks_ = 0;
  Nanoseconds still_{0}, pulling_{0}, since_{0};
  bool stands_still_ = false;
};

}  // namespace feltwire

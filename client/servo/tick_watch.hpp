#pragma once
// Tells from looks at a count of ticks that a servo thread stands still. No clock: a program that
// was stopped as a whole, and its watch with it, has not stood still.

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

class TickWatch {
 public:
  static constexpr int kLooks = 10;  // in the time for which a force may be held without a tick
  static constexpr Nanoseconds kIdle = std::chrono::seconds(2);  // likewise where there is no force
  static constexpr Nanoseconds kGrace = std::chrono::seconds(1);

  enum class Verdict : std::uint8_t {
    ticks,
    stands_still,  // from now on, every time: the device is to be let go
    gone           // for kGrace after that, too: nobody waits for it any more
  };

  /// A force is held for at most `hold` without a tick.
  explicit TickWatch(Nanoseconds hold) : interval_(hold / kLooks) {}

  /// Between looks.
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

#pragma once

#include <algorithm>
#include <chrono>
#include <thread>

#include "client/device/device.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

/// Waits for the ticks of a device outside of a session: for the device's own, or where it sets no
/// pace, for those of a timer. Ticks that were slept through are not made up for.
class TickPace {
 public:
  TickPace(Device& device, Nanoseconds period)
      : device_(device),
        paced_(device.longest_tick() > Nanoseconds(0)),
        period_(period),
        next_(monotonic_now()) {}

  /// False: no tick of the device's own came within `patience`.
  bool wait(Nanoseconds patience) {
    if (paced_) return device_.await_tick(monotonic_now() + patience);
    next_ = std::max(next_ + period_, monotonic_now() - period_);
    std::this_thread::sleep_until(std::chrono::steady_clock::time_point(next_));
    return true;
  }

 private:
  Device& device_;
  bool paced_;
  Nanoseconds period_, next_;
};

}  // namespace feltwire

#pragma once
// When to ping a viewer that says nothing, and when it counts as gone. It has no clock.

#include <algorithm>
#include <chrono>

#include "core/base/time.hpp"

namespace feltwire::web {

class PingSchedule {
 public:
  /// Time without a frame of the viewer, or since the last ping, after which it gets a ping.
  /// Proxies end a connection after 60 s without any byte.
  static constexpr Nanoseconds kIdle = std::chrono::seconds(20);
  /// Time without a frame of the viewer after which it is gone: three pings had no answer.
  static constexpr Nanoseconds kGone = std::chrono::seconds(75);

  enum class Step { wait, ping, gone };

  explicit PingSchedule(Nanoseconds begin) noexcept : heard_(begin), pinged_(begin) {}
  /// A frame of the viewer has begun.
  void hear(Nanoseconds now) noexcept { heard_ = std::max(heard_, now); }
  /// Returns what to do now. After `ping` it expects that the ping is sent.
  Step step(Nanoseconds now) noexcept {
    if (now - heard_ >= kGone) return Step::gone;
    if (now - std::max(heard_, pinged_) < kIdle) return Step::wait;
    pinged_ = now;
    return Step::ping;
  }

 private:
  Nanoseconds heard_, pinged_;
};

}  // namespace feltwire::web

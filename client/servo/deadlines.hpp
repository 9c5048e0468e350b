#pragma once
// The deadlines of the servo's ticks, and how much sooner the thread asks the machine to wake.

#include <algorithm>
#include <chrono>
#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Deadlines start + n T, n = 1, 2, ..., and the times to wake for them.
class Deadlines {
 public:
  Deadlines(Nanoseconds start, Nanoseconds period) noexcept
      : latest_(start), period_(period), longest_lead_(std::min(kLongestLead, period / 4)) {}

  /// Returns how many deadlines have passed by `now` since the last call; latest() is the last of
  /// them.
  std::uint64_t passed(Nanoseconds now) noexcept {
    if (now < next()) return 0;
    const std::int64_t count = (now - latest_) / period_;
    latest_ += count * period_;
    return static_cast<std::uint64_t>(count);
  }
  Nanoseconds latest() const { return latest_; }
  Nanoseconds next() const { return latest_ + period_; }

  /// The time before a deadline at which the thread asks to be woken: the lateness that nine
  /// wakings of ten do not exceed (60 us on a virtual machine, 3 us on a tuned one). The thread
  /// spins for the rest.
  Nanoseconds lead() const { return lead_; }
  /// The thread slept until then and woke `late` after it.
  void woken(Nanoseconds late) noexcept {
    lead_ += late > lead_ ? 9 * kLeadStep : -kLeadStep;  // settles where one in ten is later
    lead_ = std::clamp(lead_, Nanoseconds(0), longest_lead_);
  }

 private:
  static constexpr Nanoseconds kLongestLead = std::chrono::microseconds(100);
  static constexpr Nanoseconds kLeadStep = Nanoseconds(200);
  Nanoseconds latest_, period_, longest_lead_;
  Nanoseconds lead_{0};
};

}  // namespace feltwire

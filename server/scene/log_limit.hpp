#pragma once
// Limits a log line for an event that may occur a thousand times a second.

#include <cstdint>
#include <optional>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Lets the first event through at once, and later ones at most once in kPause.
class LogLimit {
 public:
  static constexpr Nanoseconds kPause = std::chrono::seconds(1);

  /// Counts `events` more. Returns the number since the last line, if a line is due now.
  std::optional<std::uint64_t> count(std::uint64_t events, Nanoseconds now) noexcept {
    untold_ += events;
    if (untold_ == 0 || (last_ && now - *last_ < kPause)) return std::nullopt;
    last_ = now;
    const std::uint64_t told = untold_;
    untold_ = 0;
    return told;
  }

 private:
  std::uint64_t untold_ = 0;
  std::optional<Nanoseconds> last_;  // time of the last line
};

/// For a growing total: lets the first event through, and then a line when the total has at least
/// doubled since the last line, at most one in kPause.
class DoublingLimit {
 public:
  /// `total`: events since the start. True: a line is due now.
  bool due(std::uint64_t total, Nanoseconds now) noexcept {
    if (total == 0 || total / 2 < told_ || (last_ && now - *last_ < LogLimit::kPause)) return false;
    last_ = now;
    told_ = total;
    return true;
  }
  /// The count of the events starts again from zero.
  void begin_anew() noexcept { told_ = 0; }

 private:
  std::uint64_t told_ = 0;
  std::optional<Nanoseconds> last_;  // time of the last line
};

}  // namespace feltwire

#pragma once
// The punctuality of a client: its servo's wake-ups and the server's answers, counted by their
// times.

#include <array>
#include <chrono>
#include <cstddef>
#include <cstdint>

namespace feltwire {

/// Counts so far, modulo 2^16: small enough for a datagram, and correct after any loss, as long as
/// one of them arrives before 2^16 more events. Class i has the times up to limit i and above the
/// limit before; the last class has all longer times.
struct HandTimes {
  static constexpr std::size_t kClasses = 8;
  using Limits = std::array<std::chrono::nanoseconds, kClasses - 1>;
  using Counts = std::array<std::uint16_t, kClasses>;

  Counts wakeups{};      // of the servo, by how late after its deadline
  Counts round_trips{};  // of answers, by the time since the device was read
};

namespace hand_time_limits {
using namespace std::chrono_literals;
inline constexpr HandTimes::Limits kWakeups{20us, 50us, 100us, 200us, 500us, 1ms, 10ms};
inline constexpr HandTimes::Limits kRoundTrips{200us, 500us, 1ms, 2ms, 5ms, 20ms, 100ms};
}  // namespace hand_time_limits

/// Counts one time.
constexpr void count(HandTimes::Counts& counts, const HandTimes::Limits& limits,
                     std::chrono::nanoseconds time) noexcept {
  std::size_t i = 0;
  while (i < limits.size() && time > limits[i]) ++i;
  ++counts[i];
}

/// A server's counts of a client since the session began.
class HandTimesHeard {
 public:
  using Totals = std::array<std::uint64_t, HandTimes::kClasses>;

  HandTimesHeard() = default;
  /// The counts of another server, since the session began.
  HandTimesHeard(const Totals& wakeups, const Totals& round_trips)
      : heard_(true), wakeups_(wakeups), round_trips_(round_trips) {}

  /// The first received counts are the start: a client that joined again has counted before.
  void take(const HandTimes& said) noexcept {
    if (heard_) add(said.wakeups, last_.wakeups, wakeups_);
    if (heard_) add(said.round_trips, last_.round_trips, round_trips_);
    last_ = said;
    heard_ = true;
  }

  bool heard() const noexcept { return heard_; }
  const Totals& wakeups() const noexcept { return wakeups_; }
  const Totals& round_trips() const noexcept { return round_trips_; }

 private:
  static void add(const HandTimes::Counts& now, const HandTimes::Counts& before,
                  Totals& totals) noexcept {
    for (std::size_t i = 0; i < totals.size(); ++i)
      totals[i] += static_cast<std::uint16_t>(now[i] - before[i]);
  }

  HandTimes last_;
  bool heard_ = false;
  Totals wakeups_{}, round_trips_{};
};

/// [s] A client sends its counts at most once in this time, with a report.
inline constexpr double kBetweenTimes = 0.5;

}  // namespace feltwire

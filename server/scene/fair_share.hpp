#pragma once
// Divides a scene's thread among its sessions if there is not enough of it. It has no clock: spent
// time and present time are arguments.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Charges the thread's time to sessions. While it is short, sessions whose use is above the fair
/// level are not answered. The level is the max-min fair one: the unused rest of an equal share is
/// divided among the other sessions. So a session that needs less than its share loses nothing to
/// one that needs more.
///
/// The use of a session is the time of its datagrams in the last kWindow, older time fading
/// exponentially. The thread is short of time if the sum is above kMost of the window.
class FairShare {
 public:
  static constexpr double kWindow = 0.1;  // [s]
  /// Share of the time that a thread spends on sessions; the rest is for joins, timers and ends.
  static constexpr double kMost = 0.9;
  /// Smallest share of it for sessions, for every load by moving objects and strangers.
  static constexpr double kLeast = 0.3;
  /// [s] No charge is larger than this: if a thread stood still for longer, other programs kept it
  /// from its work.
  static constexpr double kLongest = 0.02;
  static constexpr Nanoseconds kBalance{1'000'000};  // [ns] between two balances
  static constexpr double kLook = 1.0;               // [s] time over which a mean answer is taken
  static constexpr std::size_t kTogether = 64;  // largest number of datagrams between two charges

  explicit FairShare(std::size_t sessions);

  /// A session whose datagrams are so far apart [s]. Precondition: there are fewer than `sessions`.
  std::uint32_t add(double interval) noexcept;
  void remove(std::uint32_t session) noexcept;

  /// A datagram is taken up, from any sender.
  void take_up() noexcept { ++taken_; }
  /// It belongs to this session: its seal proves it. The number alone proves nothing.
  void attribute_to(std::uint32_t session) noexcept {
    if (recent_count_ < kTogether) recent_[recent_count_++] = session;
  }
  /// Charges the time of all datagrams since the last charge. Each sender is charged the same part.
  void charge(Nanoseconds spent) noexcept;
  /// Charges the time of other work.
  void charge_other(Nanoseconds spent) noexcept {
    other_.fresh += std::clamp(seconds(spent), 0.0, kLongest);
  }
  /// Computes the balance, once in kBalance.
  void balance(Nanoseconds now) noexcept {
    if (!last_ || now - *last_ >= kBalance) balance_now(now);
  }

  /// Whether a session's next samples are computed; counts those that are not.
  bool admit(std::uint32_t session) noexcept {
    Use& use = uses_[session];
    if (use.spent + use.fresh <= level_) return true;
    ++use.shed;
    return false;
  }
  /// [s] of the thread's time in the window that a session may have used; infinite while there is
  /// enough.
  double level() const { return level_; }
  /// The share of the thread's time that was used in the window, at the last balance.
  double load() const { return load_; }
  /// [s] of the window, at the last balance.
  double used(std::uint32_t session) const { return uses_[session].spent; }

  /// Seconds, of one session each, in which the answers to its datagrams took longer than their
  /// distance; and both times [s] of the newest of these.
  struct Slow {
    std::uint64_t seconds = 0;
    double answer = 0.0, interval = 0.0;
  };
  const Slow& slow() const { return slow_; }

 private:
  struct Use {
    bool here = false;
    double interval = 0.0;  // [s]
    double fresh = 0.0;     // [s] since the last balance
    double spent = 0.0;     // [s] in the window
    double time = 0.0;      // [s] since the last second began, for so many datagrams
    std::uint64_t datagrams = 0, shed = 0;
  };
  void balance_now(Nanoseconds now) noexcept;
  void look_for_slow(Nanoseconds now) noexcept;
  void find_level() noexcept;

  std::vector<Use> uses_;  // by session
  std::size_t end_ = 0;    // index after the last one ever used
  Use other_;
  std::array<std::uint32_t, kTogether> recent_{};
  std::size_t recent_count_ = 0, taken_ = 0;
  double level_ = std::numeric_limits<double>::infinity();
  double load_ = 0.0;
  std::optional<Nanoseconds> last_, second_began_;
  Slow slow_;
};

}  // namespace feltwire

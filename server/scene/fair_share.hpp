#pragma once
// Who gets a scene's thread when there is not enough of it. No clock: what was spent and what time
// it is are arguments.

#include <algorithm>
#include <array>
#include <cstdint>
#include <limits>
#include <optional>
#include <vector>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Accounts the thread's time to sessions. While it is short, sessions whose use is above the fair
/// level are not answered: the level is the max-min fair one (what a session leaves of an equal
/// share is shared among the others), so that a session that asks for less than its share loses
/// nothing to one that asks for more.
///
/// The use of a session is what its datagrams took in the last kWindow, older time fading
/// exponentially. The thread is short when all of it is above kMost of the window.
class FairShare {
 public:
  static constexpr double kWindow = 0.1;  // [s]
  /// Share of its time that a thread spends on sessions: the rest is for joins, timers and ends.
  static constexpr double kMost = 0.9;
  /// Share of it that sessions have at least, however long what moves and strangers take.
  static constexpr double kLeast = 0.3;
  /// [s] More is charged for no charge: a thread that stood still for longer was kept from its work
  /// by other programs.
  static constexpr double kLongest = 0.02;
  static constexpr Nanoseconds kBalance{1'000'000};  // [ns] between two looks at who has how much
  static constexpr double kLook = 1.0;               // [s] of which a mean answer is taken
  static constexpr std::size_t kTogether = 64;       // datagrams between two charges, at most

  explicit FairShare(std::size_t sessions);

  /// A session whose datagrams are so far apart [s]. Precondition: there are fewer than `sessions`.
  std::uint32_t add(double interval) noexcept;
  void remove(std::uint32_t session) noexcept;

  /// A datagram is taken up, whosever it is.
  void take_up() noexcept { ++taken_; }
  /// It is this session's: its seal says so, and not the number that anybody may write on it.
  void attribute_to(std::uint32_t session) noexcept {
    if (recent_count_ < kTogether) recent_[recent_count_++] = session;
  }
  /// Tells how long all that was taken up since the last charge took together. Each sender is
  /// charged the same part.
  void charge(Nanoseconds spent) noexcept;
  /// Tells how long something else took.
  void charge_other(Nanoseconds spent) noexcept {
    other_.fresh += std::clamp(seconds(spent), 0.0, kLongest);
  }
  /// Looks who has how much, once in kBalance.
  void balance(Nanoseconds now) noexcept {
    if (!last_ || now - *last_ >= kBalance) balance_now(now);
  }

  /// Whether a session's next samples are computed; counts where they are not.
  bool admit(std::uint32_t session) noexcept {
    Use& use = uses_[session];
    if (use.spent + use.fresh <= level_) return true;
    ++use.shed;
    return false;
  }
  /// [s] of the thread's time in the window that a session may have used; infinite while there is
  /// enough.
  double level() const { return level_; }
  /// [s] of the window, as it was at the last look.
  double used(std::uint32_t session) const { return uses_[session].spent; }

  /// Seconds, of one session each, in which its datagrams took longer to answer than they were
  /// apart; and of the newest of these, both times [s].
  struct Slow {
    std::uint64_t seconds = 0;
    double answer = 0.0, interval = 0.0;
  };
  const Slow& slow() const { return slow_; }

 private:
  struct Use {
    bool here = false;
    double interval = 0.0;  // [s]
    double fresh = 0.0;     // [s] since the last look
    double spent = 0.0;     // [s] in the window
    double time = 0.0;      // [s] since the last second began, for so many datagrams
    std::uint64_t datagrams = 0, shed = 0;
  };
  void balance_now(Nanoseconds now) noexcept;
  void look_for_slow(Nanoseconds now) noexcept;
  void find_level() noexcept;

  std::vector<Use> uses_;  // by session
  std::size_t end_ = 0;    // of those that have ever been there
  Use other_;
  std::array<std::uint32_t, kTogether> recent_{};
  std::size_t recent_count_ = 0, taken_ = 0;
  double level_ = std::numeric_limits<double>::infinity();
  std::optional<Nanoseconds> last_, second_began_;
  Slow slow_;
};

}  // namespace feltwire

#pragma once
// A scene whose thread has too little time asks clients for fewer datagrams.

#include <cstdint>
#include <optional>
#include <string>
#include <utility>

#include "server/scene/fair_share.hpp"
#include "server/scene/scene_log.hpp"
#include "server/scene/session_slot.hpp"
#include "server/scene/slow_down.hpp"

namespace feltwire {

struct PaceCounters {
  std::uint64_t slowed = 0;  // steps of a session to a slower pace
};

/// Asks the clients of busy sessions for a datagram only every second, fourth or eighth packet
/// interval, while the thread is short of time (FairShare), and takes that back step by step.
///
/// Kinds of sessions are slowed down in an order (slow_down.hpp): a kind only while no session of
/// the kinds before it can be slowed down further. A session is slowed down if it uses as much as
/// its share of the time, so that a session that needs little keeps its rate. The client goes on
/// with its own loop, and the pause between two datagrams stays below a quarter of the hold time
/// (client/transport/sample_packer.hpp): so the force on a hand has no jump, and its account stays
/// as it is.
///
/// Never allocates, but in line(). It has no clock.
class Pace {
 public:
  static constexpr std::uint8_t kMost = 8;         // packet intervals
  static constexpr Nanoseconds kLook{50'000'000};  // between two looks
  static constexpr Nanoseconds kShort{
      250'000'000};  // the thread is short for so long before a step
  static constexpr Nanoseconds kSettle{300'000'000};  // between two steps of a session
  /// A step back comes after so much time without want, and twice as much whenever that was too
  /// early, up to kLongestCalm.
  static constexpr Nanoseconds kCalm{2'000'000'000}, kLongestCalm{60'000'000'000};
  /// A step back at most doubles the load, so that it is made below this.
  static constexpr double kCalmLoad = 0.4;
  static constexpr Nanoseconds kBetweenLines{1'000'000'000};

  /// `log` must outlive this.
  Pace(SlowDownOrder order, SceneLog& log) : order_(std::move(order)), log_(log) {}

  /// Looks at all sessions, once in kLook.
  void adapt(const SessionSlots& slots, const FairShare& share, Nanoseconds now) noexcept {
    if (!looked_ || now - *looked_ >= kLook) look(slots, share, now);
  }
  /// Sets the pace of a session.
  void set(SessionSlot& slot, std::uint8_t intervals, Nanoseconds now) noexcept;

  const PaceCounters& counters() const noexcept { return counters_; }
  /// Whether line() has something to tell: a pace has changed, and the last line is a second old.
  bool has_line(Nanoseconds now) const noexcept {
    return changed_ && (!told_ || now - *told_ >= kBetweenLines);
  }
  /// The paces of all sessions now, for the log.
  std::string line(const SessionSlots& slots, Nanoseconds now);

 private:
  void look(const SessionSlots& slots, const FairShare& share, Nanoseconds now) noexcept;
  bool slow_down(const SessionSlots& slots, const FairShare& share, Slowed kind,
                 Nanoseconds now) noexcept;
  void speed_up(const SessionSlots& slots, Nanoseconds now) noexcept;

  SlowDownOrder order_;
  SceneLog& log_;
  std::optional<Nanoseconds> looked_, short_since_, calm_since_, sped_up_, told_,
      limited_;         // the thread was so short of time that shares were limited
  double level_ = 0.0;  // [s] of the window that a session might use then
  Nanoseconds calm_ = kCalm;
  PaceCounters counters_;
  bool changed_ = false;  // since the last line
};

}  // namespace feltwire

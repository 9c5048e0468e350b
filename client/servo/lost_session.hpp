#pragma once
// Whether the server of a session still answers, and since when it does not.

#include <chrono>
#include <utility>

#include "client/servo/servo_loop.hpp"

namespace feltwire {

/// For the servo thread; nothing here allocates or throws.
class LostSession {
 public:
  explicit LostSession(Nanoseconds start) noexcept : last_heard_(start) {}

  bool lost() const noexcept { return lost_; }
  /// The server ended the session; nothing is sent to it.
  bool server_left() const noexcept { return server_left_; }
  EndReason lost_by() const noexcept { return lost_by_; }                          // if lost()
  Nanoseconds lost_for(Nanoseconds now) const noexcept { return now - lost_at_; }  // if lost()
  Nanoseconds silent_for(Nanoseconds now) const noexcept { return now - last_heard_; }

  /// A reply to a newer sample came. Nothing else shows that the server is alive.
  void heard(Nanoseconds now) noexcept { last_heard_ = now; }
  void server_leaves() noexcept { server_left_ = true; }

  /// The session is lost. Returns whether it was not before.
  bool lose(Nanoseconds now, EndReason reason) noexcept {
    if (lost_) return false;
    lost_ = true;
    lost_at_ = now;
    lost_by_ = reason;
    return true;
  }

  /// Whether it is time to look for another route to a silent server.
  bool may_reroute(Nanoseconds now) noexcept {
    // It leaves time for an answer over the last route.
    constexpr Nanoseconds kReroutePeriod = std::chrono::seconds(1);
    if (!lost_ || now < next_reroute_) return false;
    next_reroute_ = now + kReroutePeriod;
    return !server_left_;
  }

  /// Whether the old session goes on: its server answers again.
  bool answered_again() const noexcept { return lost_ && !server_left_ && last_heard_ > lost_at_; }
  /// The session goes on, or a new one began. Returns whether it was lost.
  bool found() noexcept {
    server_left_ = false;
    return std::exchange(lost_, false);
  }

 private:
  bool server_left_ = false, lost_ = false;
  Nanoseconds lost_at_{0}, next_reroute_{0}, last_heard_;
  EndReason lost_by_ = EndReason::server_silent;
};

}  // namespace feltwire

#pragma once
// A robot whose states come from a program of its own: which state counts, and which target the
// robot gets. docs/followers.md has these rules.

#include "core/teleoperation/follower.hpp"

namespace feltwire {

/// A single thread uses it. No function allocates, throws or reads a clock.
class ReportedRobot {
 public:
  /// Without a new state for this time the robot is not ok.
  static constexpr Nanoseconds kSilent = std::chrono::milliseconds(100);

  ReportedRobot() noexcept { state_.ok = false; }

  /// A new state, from `when`.
  void report(const FollowerReading& state, Nanoseconds when) noexcept {
    state_ = state;
    reported_ = true;
    reported_at_ = when;
  }
  bool has_reported() const noexcept { return reported_; }

  /// The reading at `now`: the newest state. It is not ok if there is none yet, if it is older than
  /// kSilent, or if the program is not `connected`.
  FollowerReading read(Nanoseconds now, bool connected) noexcept;

  /// The target that the robot gets, after read(): the given one. A robot that is stopped, silent,
  /// not ok or `held` gets the target that its newest state says it has. A target that is not
  /// finite changes nothing. Before the first state the given target is returned, and the robot
  /// must get none, because its position is not known.
  FollowerTarget write(const FollowerTarget& target, bool held) noexcept;

 private:
  FollowerReading state_;
  bool reported_ = false;
  bool fresh_ = false;  // at the last read()
  Nanoseconds reported_at_{0};
  FollowerTarget target_;  // the last one
};

}  // namespace feltwire

#pragma once
// A robot that the program which uses the library is itself: it gives its state, and moves to the
// target that it is given.

#include <atomic>
#include <cstdint>
#include <string>

#include "client/c_api/feltwire.h"
#include "client/followers/reported_robot.hpp"
#include "core/base/latest_value.hpp"
#include "core/teleoperation/follower.hpp"
#include "core/teleoperation/robot.hpp"

namespace feltwire {

/// The program's thread calls report(). The loop of the follower calls the rest; latest() and
/// hold() any thread may call. Nothing waits or allocates.
class CallerRobot final : public Follower {
 public:
  explicit CallerRobot(FollowerSpec spec) : spec_(std::move(spec)) {}

  /// The robot's state at `now` (monotonic). Throws std::invalid_argument that names the field if
  /// no robot can be in it.
  void report(const fw_robot_state& state, Nanoseconds now);
  /// Returns the newest target in `target` with its age at `now`; false: there is none yet.
  bool latest(fw_robot_target& target, Nanoseconds now) const noexcept;

  const FollowerSpec& spec() const override { return spec_; }
  FollowerReading read(Nanoseconds now) noexcept override;
  FollowerTarget write(const FollowerTarget& target) noexcept override;
  void hold() noexcept override { held_.store(true); }

  /// After a sample of the loop: gives its target to the program, once the program has reported a
  /// state.
  void publish(const RobotState& said, const RobotTarget& newest, bool connected) noexcept;

 private:
  struct Report {
    fw_robot_state state;
    std::int64_t clock;  // [ns] monotonic
  };
  struct Target {
    fw_robot_target target;
    std::int64_t commanded_at;  // [ns] monotonic; 0: no command has come
  };

  FollowerSpec spec_;
  LatestValue<Report> reports_;
  LatestValue<Target> targets_;
  std::atomic<bool> held_{false};
  // Members of the loop's thread.
  ReportedRobot robot_;
  std::uint64_t reports_read_ = 0;
  std::uint64_t newest_command_ = 0;  // RobotTarget::index
  std::int64_t commanded_at_ = 0;     // [ns]
  double gripper_ = 0.0;              // [m] of the last target
};

}  // namespace feltwire

#pragma once
// A servo sample of a robot that follows: its input is the reading, its output the target until
// the next sample. It has no socket, clock or thread.

#include <cstdint>
#include <memory>
#include <optional>

#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/follower.hpp"
#include "core/teleoperation/gripper_follow.hpp"
#include "core/teleoperation/link_states.hpp"
#include "core/teleoperation/motion_limit.hpp"
#include "core/teleoperation/robot.hpp"
#include "core/teleoperation/surface_model.hpp"
#include "core/teleoperation/target_limiter.hpp"
#include "core/teleoperation/workspace.hpp"

namespace feltwire {

struct FollowerOptions {
  MotionLimits motion;
  GripperLimits gripper;
  double leash = 20.0;       // [N] largest force of the controller's spring
  double first_touch = 3.0;  // [N] while the hand does not know of the contact
  double unfelt = 3.0;       // [N] force that the hand need not have paid for
  Workspace workspace;       // limits of its target, in addition to those of its seat; at most
                             // kMostGiven walls
  std::shared_ptr<SurfaceModel> surfaces = {};  // model of what it may touch; null: none
  /// Without a target for this time the robot brakes and holds.
  Nanoseconds silence = std::chrono::milliseconds(100);
};
/// Throws std::invalid_argument that names the limit, its value and the remedy.
void validate(const FollowerOptions& options);

struct FollowerStatistics {
  std::uint64_t samples = 0;
  std::uint64_t targets = 0;        // taken
  std::uint64_t targets_stale = 0;  // not newer than the one in use, so without effect
  std::uint64_t engagements = 0;    // times that the robot began to follow
  std::uint64_t holds = 0;          // times that it stopped following
  std::uint64_t faults =
      0;  // readings that were faulty, not finite, or far from the target after a jump
  double largest_force = 0.0;  // [N] of the environment on the tool
  LinkStates link_states;      // as the targets told them
};

/// The way from a target to the robot, in this order:
///   1. it follows while the newest target says `engaged`, is young, and the robot is well; else it
///      brakes, or stands at once where it touches something;
///   2. the workspace, its own and that of its seat (WorkspaceLimit), before and after
///   3. the limits of motion (MotionLimit);
///   4. first touch, felt, leash (TargetLimiter); the gripper follows at its own speed
///      (GripperFollow);
/// and its state: its pose and wrench, the surface that it touches (ContactEstimator) with the
/// stiffness of surface and robot in series, and its energy (ContactEnergy).
///
/// When it begins to follow, it starts from the target that it holds: earlier targets do not count.
/// Its target is then not farther behind a wall of the workspace than it was, for every received
/// target. It is behind one only if an object has pushed the robot there, and the spring, never
/// stronger than the leash, pulls it back. A reading that is faulty or not finite moves nothing.
/// After a jump of the readings (kJump) it is not well: it stops following, and its target stays.
/// It is well again once the readings are as near to the target as the leash allows: nobody knows
/// where a robot is that reads otherwise. It allocates only at construction.
class FollowerServo {
 public:
  /// A reading is a jump if it is this many times as far away as the speed limit allows.
  static constexpr double kJump = 10.0;

  /// Throws std::invalid_argument that names the number and the remedy.
  FollowerServo(const FollowerSpec& spec, const FollowerOptions& options = {});

  /// The workspace of the seat, in addition to its own; both apply from the next sample on.
  void sit(const Workspace& seat) noexcept;

  /// A target, received at `now`. One that is not newer changes nothing.
  void take(const RobotTarget& target, Nanoseconds now) noexcept;

  /// Takes one sample: returns the target for write(), from the reading at `now`.
  FollowerTarget step(const FollowerReading& reading, Nanoseconds now) noexcept;
  /// Returns the state for the server, after write() returned `held`. Valid until the next call.
  const RobotState& report(const FollowerTarget& held) noexcept;

  /// Does one whole sample: read, step, write, report.
  const RobotState& tick(Follower& robot, Nanoseconds now) noexcept {
    return report(robot.write(step(robot.read(now), now)));
  }

  /// Another session: its targets are counted from 1 again. The robot holds.
  void reconnected() noexcept;

  bool follows() const noexcept { return following_; }
  /// The last result of step().
  const FollowerTarget& wanted() const noexcept { return wanted_; }
  /// The newest target of this session; index 0: none yet.
  const RobotTarget& target() const noexcept { return target_; }
  const FollowerStatistics& statistics() const noexcept { return statistics_; }

 private:
  bool may_follow(const FollowerReading& reading, Nanoseconds now) const noexcept;
  bool jumped(const Vec3& tip, Nanoseconds now) const noexcept;
  void lose(const Vec3& tip, Nanoseconds now) noexcept;
  void sense(const FollowerReading& reading, double elapsed) noexcept;
  void steer(bool follow, double elapsed) noexcept;

  FollowerSpec spec_;
  FollowerOptions options_;
  ContactEstimator estimate_;
  ContactEnergy energy_;
  WorkspaceLimit limit_;
  MotionLimit motion_;
  GripperFollow gripper_;
  TargetLimiter limiter_;
  RobotTarget target_;  // the newest; index 0: none yet
  Nanoseconds heard_{0};
  bool begun_ = false, following_ = false;
  bool lost_ = false;        // after a jump
  Nanoseconds last_{0};      // the time of the sample before
  Vec3 tip_ = Vec3::Zero();  // [m] there
  FollowerTarget wanted_;    // to be written
  std::uint32_t known_ = 0;  // from the newest target that was followed
  double hand_work_ = 0.0;   // the same
  RobotState state_;
  FollowerStatistics statistics_;
};

}  // namespace feltwire

#pragma once
// The interface of a robot that follows a leader's hand. Implement it to attach one.

#include <optional>
#include <string>

#include "core/base/time.hpp"
#include "core/base/types.hpp"

namespace feltwire {

/// The properties of a follower. They must not change while it runs.
struct FollowerSpec {
  std::string name;
  double servo_period = 1e-3;    // [s] between two calls of read()
  double stiffness = 1000.0;     // [N/m] of its own impedance controller, every direction, > 0
  double damping = 0.0;          // [N s/m] of that controller, >= 0
  double own_damping = 0.0;      // [N s/m] lower bound of the damping of the robot's own body
  double mass = 0.0;             // [kg] apparent at the tool; 0: not known
  bool senses_wrench = true;     // false: FollowerReading::external is an estimate
  double wrench_noise = 0.0;     // [N] largest error of a measured force
  double gripper_opening = 0.0;  // [m] at most; 0: it has no gripper
};

/// A reading of a robot, in the robot's world frame.
struct FollowerReading {
  Pose pose;                             // of the tool
  Vec3 velocity = Vec3::Zero();          // [m/s] of the tool
  Vec3 angular_velocity = Vec3::Zero();  // [rad/s]
  std::optional<Vec3> force;             // [N] of the environment on the tool; none: not sensed
  Vec3 torque = Vec3::Zero();            // [N m] of the environment on the tool, about it
  Pose commanded;                        // the target that its controller holds now
  double gripper = 0.0;                  // [m] opening
  double gripper_force = 0.0;            // [N] holding force of the gripper
  bool ok = true;                        // false: it has a fault; it must hold by itself
  bool stopped = false;                  // a protective stop, by the robot or by a person
};

/// The wanted place of the tool.
struct FollowerTarget {
  Pose pose;
  double gripper = 0.0;  // [m] opening
};

/// A robot with an impedance controller of its own. One thread calls read() and then write(), once
/// each servo period. Neither may block, allocate or throw. Between two targets, and when no more
/// come, its controller holds the last one.
class Follower {
 public:
  virtual ~Follower() = default;
  virtual const FollowerSpec& spec() const = 0;
  /// The state at `now`, a monotonic time. A simulated robot moves up to that time.
  virtual FollowerReading read(Nanoseconds now) noexcept = 0;
  /// Returns the target that is really held, which may differ (joint limits, a stop).
  virtual FollowerTarget write(const FollowerTarget& target) noexcept = 0;
  /// The robot stays at its place from now on, and later targets change nothing. Any thread may
  /// call it, more than once.
  virtual void hold() noexcept = 0;
};

}  // namespace feltwire

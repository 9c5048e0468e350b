#pragma once
// A simulated robot: a seven-axis arm with a gripper in MuJoCo, and the objects that it touches.

#include <atomic>
#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>

#include "core/base/types.hpp"
#include "core/teleoperation/arm_control.hpp"
#include "core/teleoperation/follower.hpp"

namespace feltwire {

struct ArmConfig : ArmControl {
  std::filesystem::path file;  // MJCF of the arm with its surroundings
  double servo_period = 1e-3;  // [s] of the spec, > 0
};

/// A DrivenArm in a simulation of its own (core/arm/driven_arm.hpp has its parts, its controller
/// and its sensor). A step is the file's timestep.
///
/// Deterministic: the same config and calls give the same bits. Times are multiples of a step, from
/// the first read() on; a jump of more than 1 s is taken as 1 s. It allocates only at construction.
class Arm final : public Follower {
 public:
  /// Throws FileError if the file is not such an arm, std::invalid_argument if a number of the
  /// config cannot be used.
  explicit Arm(const ArmConfig& config);
  ~Arm() override;
  Arm(const Arm&) = delete;
  Arm& operator=(const Arm&) = delete;

  const FollowerSpec& spec() const override;
  FollowerReading read(Nanoseconds now) noexcept override;
  FollowerTarget write(const FollowerTarget& target) noexcept override;
  void hold() noexcept override { held_.store(true); }

  /// Ends a protective stop. The thread of read() and write() calls it.
  void resume() noexcept;

  // For tests, studies and pictures; the thread of read() and write() calls them.
  /// [N] on the tool from now on, as if a person pushed it.
  void push(const Vec3& force) noexcept;
  /// [N] of the surroundings on the tool in the last step, as the simulation knows it.
  Vec3 contact_force() const noexcept;
  /// [J] energy of the arm: its springs and its movement.
  double energy() const noexcept;
  /// [rad] of an axis, 0 to 6; [N m] of its motor in the last step; its limits.
  double angle(int axis) const noexcept;
  double torque(int axis) const noexcept;
  struct Limits {
    double low, high, torque;
  };
  Limits limits(int axis) const noexcept;
  /// [m] place of a body of the file; empty: there is no such body.
  std::optional<Vec3> place_of(const std::string& body) const;

 private:
  struct Simulation;

  void step() noexcept;

  std::unique_ptr<Simulation> sim_;
  std::atomic<bool> held_{false};
  bool halted_ = false;  // by hold()
  bool begun_ = false;
  Nanoseconds start_{0};
  std::int64_t steps_ = 0;
};

/// Moves an arm at rest to `place` [m], straight, within 3 s, and lets it rest for 1 s. It keeps
/// the tool's orientation, and opens the gripper by `gripper` [m]. `now` is the time of its next
/// reading, and then that of its last one. Returns its last target.
FollowerTarget bring(Arm& arm, const Vec3& place, double gripper, Nanoseconds& now) noexcept;

}  // namespace feltwire

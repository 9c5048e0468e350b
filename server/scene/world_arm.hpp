#pragma once
// An arm of the scene's own world on one of its seats: what a robot's program does, in the scene's
// thread.

#include <cstdint>

#include "core/arm/driven_arm.hpp"
#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"
#include "core/teleoperation/follower_servo.hpp"
#include "server/scene/teleop_link.hpp"

namespace feltwire {

/// It follows its link as every robot does (FollowerServo), one sample in each step of the world.
/// Its time is that of the world. Never allocates, except at construction.
class WorldArm {
 public:
  /// [s] A protective stop ends by itself after so long with less than half of its force and
  /// torque: nobody stands beside the arm to end it.
  static constexpr double kStopped = 1.0;

  /// Precondition: `seat` has an arm, and the world is of its scene. Throws FileError if the world
  /// has no such arm.
  WorldArm(const RemoteSeat& seat, World& world);

  /// Before a step of the world at `now`: tells the link the arm's state, takes its target, and
  /// sets the motors.
  void drive(World& world, TeleopLink& link, Nanoseconds now) noexcept;
  /// After the step.
  void sense(World& world) noexcept;

 private:
  void end_stop(double elapsed) noexcept;

  DrivenArm arm_;
  FollowerServo servo_;
  std::uint64_t resets_ = 0;  // the world's, as far as the arm knows
  double calm_ = 0.0;         // [s] since the arm was pushed hard, while it is stopped
};

}  // namespace feltwire

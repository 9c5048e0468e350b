#pragma once
// Internal to core/arm: the controller of the arm, one step at a time.

#include <vector>

#include "core/arm/arm_parts.hpp"
#include "core/teleoperation/arm_control.hpp"
#include "core/teleoperation/follower.hpp"

namespace feltwire::arm {

using Vec6 = Eigen::Matrix<double, 6, 1>;
using Mat6 = Eigen::Matrix<double, 6, 6>;
using Jacobian = Eigen::Matrix<double, 6, kAxes>;

/// State of the tool, linear above angular, as the data stands after mj_step1(). World frame.
struct ToolState {
  Pose pose;
  Vec3 velocity = Vec3::Zero(), angular_velocity = Vec3::Zero();
};

class Impedance {
 public:
  /// `data` is evaluated at home. The dampings are chosen here. All others must outlive it.
  Impedance(const ArmControl& control, const ArmParts& arm, const mjModel& model,
            const mjData& data);

  double damping() const { return damping_; }  // B [N s/m]
  double mass() const { return mass_; }        // [kg] of the tool at home

  ToolState tool(const mjData& data) const noexcept;

  /// Takes a target as far as it can be held from `tool`; one that is not finite changes nothing.
  void aim(const FollowerTarget& target, const ToolState& tool) noexcept;
  /// Sets the target to the tool's place.
  void hold(const ToolState& tool) noexcept;
  const FollowerTarget& target() const noexcept { return target_; }

  /// Divides the last movement of the target by aim() among the next `steps`. If the tool touches
  /// something, the target's velocity does not drive it, because the tool may not get there.
  void spread(int steps, bool touching) noexcept;
  /// Sets the motors. MuJoCo may fail in it, so guarded() calls it.
  void drive(mjData& data) noexcept;

  /// [J] of the springs.
  double energy(const mjData& data) const noexcept;
  /// [N] closing force of the gripper.
  double grip() const noexcept { return grip_; }

 private:
  void find_jacobian(const mjData& data) noexcept;
  Vec7 gravity(const mjData& data) const noexcept;
  Vec7 walls(const Vec7& q, const Vec7& speed) const noexcept;
  Vec7 posture(const Vec7& q, const Vec7& speed) noexcept;
  void drive_gripper(mjData& data) noexcept;

  const ArmControl& control_;
  const ArmParts& arm_;
  const mjModel& model_;
  double damping_ = 0.0, turning_damping_ = 0.0, posture_damping_ = 0.0, mass_ = 0.0;
  double share_ = 0.0;  // of the low pass, in a step
  FollowerTarget target_;
  Vec6 moved_ = Vec6::Zero();      // by aim(), not yet spread [m, rad]
  Vec6 pace_ = Vec6::Zero();       // of the target in this span [m/s, rad/s]
  Vec6 reference_ = Vec6::Zero();  // the same, low-passed
  double grip_ = 0.0;
  Jacobian jacobian_ = Jacobian::Zero();
  // Rows of MuJoCo's, over all speeds of the model.
  std::vector<mjtNum> rows_, solved_;
};

}  // namespace feltwire::arm

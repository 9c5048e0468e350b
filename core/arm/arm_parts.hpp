#pragma once
// Internal to core/arm: the indices of an arm's parts in a model of MuJoCo.

#include <array>
#include <optional>
#include <string>

#include "core/base/types.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"

namespace feltwire::arm {

inline constexpr int kAxes = 7;
using Vec7 = Eigen::Matrix<double, kAxes, 1>;

/// A joint with its motor.
struct Axis {
  int joint = 0, position = 0, speed = 0, motor = 0;  // indices: joint, qpos, qvel, ctrl
  double low = 0.0, high = 0.0;                       // [rad] or [m] its range
  double most = 0.0;                                  // [N m] or [N] largest value of the motor
};

struct ArmParts {
  std::array<Axis, kAxes> axes;
  std::optional<std::array<Axis, 2>> fingers;
  Vec7 home = Vec7::Zero();                     // [rad]
  int tool = 0, wrist = 0, balance = 0;         // sites
  int hand = 0;                                 // the body that the wrist's sensor carries
  int force = 0, torque = 0, acceleration = 0;  // of the sensors, in sensordata
  double tool_mass = 0.0;                       // [kg] of the hand and the parts fixed to it
};

/// Finds them by their names, each behind `prefix`. Throws FileError that names the file, the
/// missing or wrong part, and the remedy.
ArmParts find_arm(const mjModel& model, const std::string& file, const std::string& prefix);

/// Puts the arm to its home. `gripper` [m] opening; empty: open. `coordinates`: qpos.
void go_home(const ArmParts& arm, const std::optional<double>& gripper,
             mjtNum* coordinates) noexcept;

}  // namespace feltwire::arm

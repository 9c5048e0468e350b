#pragma once

#include <cstdint>
#include <optional>
#include <string>

namespace feltwire {

/// The controller, the sensor and the protective stop of a simulated arm (core/arm/driven_arm.hpp).
struct ArmControl {
  std::string prefix = {};             // of the names of its parts in the MJCF file
  double stiffness = 1000.0;           // K [N/m] > 0, every direction
  double turning_stiffness = 30.0;     // [N m/rad] > 0
  double damping_ratio = 1.0;          // > 0, by the tool's mass at home
  double posture_stiffness = 20.0;     // [N m/rad] >= 0 towards home, where the tool does not move
  double largest_pull = 30.0;          // [N] > 0 of the spring
  double largest_turn = 6.0;           // [N m] > 0 of the spring about the tool
  double stop_force = 60.0;            // [N] > 0: a protective stop above
  double stop_torque = 8.0;            // [N m] > 0: the same for torque
  double noise = 0.02;                 // [N] >= 0 RMS of each axis of the wrist's sensor
  double torque_noise = 0.002;         // [N m] >= 0: the same for torque
  std::optional<double> gripper = {};  // [m] >= 0 opening at the start; empty: open
  std::uint64_t seed = 1;              // of the noise
};

}  // namespace feltwire

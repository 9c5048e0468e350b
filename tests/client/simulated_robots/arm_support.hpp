#pragma once
// Shared by the tests of the simulated arm.

#include <cmath>
#include <string>

#include "client/simulated_robots/arm.hpp"

namespace feltwire::arm_test {

inline constexpr double kPeriod = 1e-3;  // [s]

inline std::string scene(const std::string& name) {
  return std::string(FELTWIRE_SOURCE_DIR) + "/scenes/arm/" + name + ".xml";
}

inline ArmConfig config_of(const std::string& name) {
  ArmConfig config;
  config.file = scene(name);
  return config;
}

/// An arm and its time, which advances by servo periods.
struct Robot {
  explicit Robot(const ArmConfig& config) : arm(config) {
    reading = arm.read(Nanoseconds(0));
    target = {reading.pose, reading.gripper};
  }
  explicit Robot(const std::string& name) : Robot(config_of(name)) {}

  double time() const { return kPeriod * static_cast<double>(ticks); }
  const FollowerReading& tick() {
    held = arm.write(target);
    reading = arm.read(std::chrono::milliseconds(++ticks));
    return reading;
  }
  void wait(double seconds) {
    const int count = static_cast<int>(std::lround(seconds / kPeriod));
    for (int i = 0; i < count; ++i) tick();
  }
  /// Moves the target to a place at a constant speed.
  void move(const Vec3& to, double seconds) {
    const Vec3 from = target.pose.position;
    const int count = static_cast<int>(std::lround(seconds / kPeriod));
    for (int i = 1; i <= count; ++i) {
      target.pose.position = from + (to - from) * (static_cast<double>(i) / count);
      tick();
    }
  }
  /// The mean of the sensor's readings [N].
  Vec3 mean_force(double seconds) {
    const int count = static_cast<int>(std::lround(seconds / kPeriod));
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < count; ++i) sum += tick().force.value_or(Vec3::Zero());
    return sum / count;
  }

  Arm arm;
  FollowerReading reading;
  FollowerTarget target, held;
  int ticks = 0;
};

}  // namespace feltwire::arm_test

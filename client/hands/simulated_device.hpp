#pragma once
// A haptic device in a simulated hand that has a task.

#include <optional>

#include "client/hands/hand_device.hpp"
#include "client/hands/hand_path.hpp"
#include "client/hands/wrist_path.hpp"

namespace feltwire {

struct SimulatedHandOptions {
  DeviceSpec
      spec;  // mass, damping, Coulomb friction, encoder quantum and maximum force are the device's
  Hand hand;
  HandTask task;
  WristTask wrist = {};                       // for a device that senses rotation
  bool own_center = true, own_normal = true;  // false: begin() gives the task's center, normal
  std::optional<double> leads_from =
      {};  // [s] time from which the switch is held that moves a robot
  /// [s] Time at which the hand presses its only button, for kPress. It lets the switch go kLetGo
  /// before, and holds it again kLetGo after.
  std::optional<double> presses_at = {};
  Plant plant = {};                                    // of the device; ideal by default
  static constexpr double kPress = 0.1, kLetGo = 0.5;  // [s]
};

/// The task gives the intended place of the hand at each time. Deterministic: the same task, forces
/// and reading times give the same bits.
class SimulatedDevice final : public HandDevice {
 public:
  /// Throws std::invalid_argument if a number is not usable (a mass that is not above zero, for
  /// example).
  explicit SimulatedDevice(const SimulatedHandOptions& options);

  void begin(const Vec3& position, const Vec3& normal) override;
  DeviceReading read(Nanoseconds now) noexcept override;

 private:
  Vec3 intended(double time) noexcept override {
    time_ = time;
    return motion_.position(time);
  }

  Vec3 intended_turn(double time) noexcept override { return turn_.rotation(time); }

  SimulatedHandOptions options_;
  IntendedMotion motion_;
  IntendedTurn turn_;
  double time_ = 0.0;  // [s] of the newest reading
};

}  // namespace feltwire

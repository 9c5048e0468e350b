#pragma once
// A haptic device in a simulated hand that has a task.

#include "client/devices/hand_device.hpp"
#include "client/devices/hand_path.hpp"

namespace feltwire {

struct SimulatedHandOptions {
  DeviceSpec
      spec;  // mass, damping, Coulomb friction, encoder quantum and maximum force are the device's
  Hand hand;
  HandTask task;
  bool own_center = true, own_normal = true;  // false: begin() says the task's center, normal
};

/// The hand means to be where its task is at that time. Deterministic: the same task, forces and
/// reading times give the same bits.
class SimulatedDevice final : public HandDevice {
 public:
  /// Throws std::invalid_argument when a number is not usable (a mass that is not above zero, say).
  explicit SimulatedDevice(const SimulatedHandOptions& options);

  void begin(const Vec3& position, const Vec3& normal) override;

 private:
  Vec3 intended(double time) noexcept override { return motion_.position(time); }

  SimulatedHandOptions options_;
  IntendedMotion motion_;
};

}  // namespace feltwire

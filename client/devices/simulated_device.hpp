#pragma once
// A haptic device in a simulated hand, integrated far finer than the servo period.

#include <atomic>
#include <memory>

#include "client/devices/device.hpp"
#include "client/devices/hand_path.hpp"

namespace feltwire {

/// The arm behind the hand: a mass that moves with the device, and a spring and damper towards
/// where it means to be.
struct Hand {
  double mass = 0.1;         // [kg]
  double damping = 5.0;      // [N s/m]
  double stiffness = 300.0;  // [N/m]
};

struct SimulatedHandOptions {
  DeviceSpec
      spec;  // mass, damping, Coulomb friction, encoder quantum and maximum force are the device's
  Hand hand;
  HandTask task;
  bool own_center = true, own_normal = true;  // false: begin() says the task's center, normal
};

/// m x'' = k (x_i - x) + b_h (x_i' - x') - B x' - f_c sign(x') + f, with m of device and hand
/// together, x_i the intended position and f the force last written, scaled down to the device's
/// maximum. Coulomb friction acts axis by axis, as in a device whose axes have a transmission each.
/// Semi-implicit Euler in steps of at most 20 us, damping implicit, Coulomb friction exact (it
/// stops the mass, it never turns it round). Readings are rounded to the encoder quantum. The hand
/// does not turn the tool: orientation stays the identity. Deterministic: the same task, forces and
/// reading times give the same bits.
class SimulatedDevice final : public Device {
 public:
  /// Throws std::invalid_argument when a number is not usable (a mass that is not above zero, say).
  explicit SimulatedDevice(const SimulatedHandOptions& options);

  const DeviceSpec& spec() const override { return options_.spec; }
  void begin(const Vec3& position, const Vec3& normal) override;
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept override;
  /// The hand moves on without the device's force.
  void release() noexcept override { released_.store(true); }

  const Vec3& true_position() const { return position_; }  // [m] what no encoder has rounded
  const Vec3& true_velocity() const { return velocity_; }  // [m/s]

 private:
  void go_to_start();
  void integrate(double until) noexcept;

  SimulatedHandOptions options_;
  IntendedMotion motion_;
  bool started_ = false;
  Nanoseconds start_{0};
  double time_ = 0.0;  // [s] since the first reading
  Vec3 intended_, position_, velocity_ = Vec3::Zero();
  Vec3 force_ = Vec3::Zero();  // [N] on the hand, held
  std::atomic<bool> released_{false};
};

}  // namespace feltwire

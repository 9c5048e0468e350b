#pragma once
// A haptic device in a simulated hand, integrated far finer than the servo period. Where the hand
// means to be, others say.

#include <atomic>

#include "client/devices/device.hpp"

namespace feltwire {

/// The arm behind the hand: a mass that moves with the device, and a spring and damper towards
/// where it means to be.
struct Hand {
  double mass = 0.1;         // [kg]
  double damping = 5.0;      // [N s/m]
  double stiffness = 300.0;  // [N/m]
};

/// m x'' = k (x_i - x) + b_h (x_i' - x') - B x' - f_c sign(x') + f, with m of device and hand
/// together, x_i the intended position and f the force last written, scaled down to the device's
/// maximum. Coulomb friction acts axis by axis, as in a device whose axes have a transmission each.
/// Semi-implicit Euler in steps of at most 20 us, damping implicit, Coulomb friction exact (it
/// stops the mass, it never turns it round). Readings are rounded to the encoder quantum. The hand
/// does not turn the tool: orientation stays the identity. Deterministic: the same intended
/// positions, forces and reading times give the same bits.
class HandDevice : public Device {
 public:
  const DeviceSpec& spec() const final { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept final;
  /// The hand moves on without the device's force.
  void release() noexcept final { released_.store(true); }

  const Vec3& true_position() const { return position_; }  // [m] what no encoder has rounded
  const Vec3& true_velocity() const { return velocity_; }  // [m/s]

 protected:
  /// Throws std::invalid_argument when a number is not usable (a mass that is not above zero, say).
  HandDevice(const DeviceSpec& spec, const Hand& hand);

  /// The hand is at this place [m], and means to be there. Before the first reading.
  void place(const Vec3& position) noexcept;

 private:
  /// Where the hand means to be [m], world frame, at `time` [s] since the first reading. Called
  /// once a reading, with rising times; in between the intended motion is straight.
  virtual Vec3 intended(double time) noexcept = 0;
  void integrate(double until) noexcept;

  DeviceSpec spec_;
  Hand hand_;
  bool started_ = false;
  Nanoseconds start_{0};
  double time_ = 0.0;  // [s] since the first reading
  Vec3 intended_ = Vec3::Zero(), position_ = Vec3::Zero(), velocity_ = Vec3::Zero();
  Vec3 force_ = Vec3::Zero();  // [N] on the hand, held
  std::atomic<bool> released_{false};
};

}  // namespace feltwire

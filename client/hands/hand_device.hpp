#pragma once
// A haptic device in a simulated hand, integrated in steps far shorter than the servo period. A
// derived class gives the intended place of the hand.

#include <atomic>
#include <optional>

#include "client/device/device.hpp"
#include "client/hands/amplifier.hpp"
#include "client/hands/hand.hpp"
#include "client/hands/plant.hpp"
#include "client/hands/plant_motion.hpp"
#include "client/hands/true_energy.hpp"

namespace feltwire {

/// m x'' = k (x_i - x) + b_h (x_i' - x') - B x' - f_c sign(x') + f, with m of device and hand
/// together, x_i the intended position and f the force last written, scaled down to the device's
/// maximum. Coulomb friction acts axis by axis, as in a device whose axes have a transmission each.
/// Semi-implicit Euler in steps of at most 20 us, damping implicit, Coulomb friction exact (it
/// stops the mass, it never turns it round). Readings are rounded to the encoder quantum.
///
/// A device that senses rotation turns in the same way, about every axis:
///   J w' = k_r log(q_i q^-1) + b_r (w_i - w) - B_r w - tau_c sign(w) + tau,   q' = w q
/// with J of device and hand together. All axes have the same inertia, so that the free handle
/// keeps w. Its encoders stand along the world's axes: a reading is the reading before, turned by
/// whole quanta about these axes, and is within half a quantum of the true orientation. The
/// orientation stays the identity if the device does not sense rotation, or if device and hand have
/// no inertia.
///
/// With a plant that is not Plant::ideal(), translation is that of PlantMotion, and the amplifier
/// stands before the torque too. Rotation has no transmission.
///
/// Deterministic: the same intended poses, commands and reading times give the same bits.
class HandDevice : public Device {
 public:
  const DeviceSpec& spec() const final { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept final;
  /// After release() the hand moves on without the device's force.
  void release() noexcept final { released_.store(true); }

  const Vec3& true_position() const { return position_; }  // [m] of the handle, not rounded
  const Vec3& true_velocity() const { return velocity_; }  // [m/s] of the handle
  /// [m] of the motor, which is where the handle is if the transmission is rigid.
  const Vec3& motor_position() const { return plant_ ? plant_->motor_position() : position_; }
  const Quaternion& true_orientation() const { return orientation_; }
  const Vec3& true_angular_velocity() const { return angular_velocity_; }  // [rad/s] world frame
  /// Without a plant of its own `to_hand` has the error of the integration: some 0.1 %.
  TrueEnergy true_energy() const noexcept;

 protected:
  /// Throws std::invalid_argument if a number is not usable (a mass that is not above zero, for
  /// example), PlantError if one of the plant is not.
  HandDevice(const DeviceSpec& spec, const Hand& hand, const Plant& plant = {});

  /// Puts the hand and its intended place here [m]. Call it before the first reading.
  void place(const Vec3& position) noexcept;

 private:
  /// Returns the intended place of the hand [m], world frame, at `time` [s] since the first
  /// reading. It is called once for each reading, with rising times. The intended motion between
  /// two calls is a straight line.
  virtual Vec3 intended(double time) noexcept = 0;
  /// Returns the intended orientation: a rotation vector [rad], world frame. Called like
  /// intended().
  virtual Vec3 intended_turn(double /*time*/) noexcept { return Vec3::Zero(); }
  void integrate(double until) noexcept;
  void move(double time, double span, int steps) noexcept;
  void move_plant(const Vec3& target, double span) noexcept;
  void look_at_energy() noexcept;
  void turn(double time, double span, int steps) noexcept;
  Quaternion measured_orientation() noexcept;

  DeviceSpec spec_;
  Hand hand_;
  bool started_ = false;
  Nanoseconds start_{0};
  double time_ = 0.0;  // [s] since the first reading
  Vec3 intended_ = Vec3::Zero(), position_ = Vec3::Zero(), velocity_ = Vec3::Zero();
  Vec3 force_ = Vec3::Zero();  // [N] on the hand, held
  bool turns_;
  Quaternion intended_orientation_ = Quaternion::Identity(), orientation_ = Quaternion::Identity(),
             measured_ = Quaternion::Identity();
  Vec3 angular_velocity_ = Vec3::Zero();
  Vec3 torque_ = Vec3::Zero();        // [N m] on the hand, held
  std::optional<PlantMotion> plant_;  // empty: the device is ideal
  std::optional<Amplifier> torque_amplifier_;
  struct Flow {
    double given = 0.0, burned = 0.0;  // [J]
  } translation_, rotation_;
  double made_ = 0.0;  // [J]
  std::atomic<bool> released_{false};
};

}  // namespace feltwire

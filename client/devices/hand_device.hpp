#pragma once
// A haptic device in a simulated hand, integrated in steps far shorter than the servo period. A
// derived class gives the intended place of the hand.

#include <atomic>

#include "client/devices/device.hpp"

namespace feltwire {

/// The arm behind the hand: a mass that moves with the device, and a spring and damper towards the
/// intended place.
struct Hand {
  double mass = 0.1;         // [kg]
  double damping = 5.0;      // [N s/m]
  double stiffness = 300.0;  // [N/m]
  // The wrist, about every axis: equal to the arm's values at a lever of kWristArm.
  double inertia = 1.6e-4;            // [kg m^2]
  double rotational_damping = 8e-3;   // [N m s/rad]
  double rotational_stiffness = 0.5;  // [N m/rad]
};
/// [m] the lever at which a wrist turns a tool.
inline constexpr double kWristArm = 0.04;
/// Returns the hand with a wrist that has its mass, damping and stiffness at that lever.
Hand with_wrist(Hand hand);
/// The parameters of a device that nobody holds.
inline constexpr Hand kNoHand = {0.0, 0.0, 0.0, 0.0, 0.0, 0.0};

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
/// Deterministic: the same intended poses, commands and reading times give the same bits.
class HandDevice : public Device {
 public:
  const DeviceSpec& spec() const final { return spec_; }
  DeviceReading read(Nanoseconds now) noexcept override;
  Command write(const Command& on_hand) noexcept final;
  /// After release() the hand moves on without the device's force.
  void release() noexcept final { released_.store(true); }

  const Vec3& true_position() const { return position_; }  // [m] not rounded by an encoder
  const Vec3& true_velocity() const { return velocity_; }  // [m/s]
  const Quaternion& true_orientation() const { return orientation_; }
  const Vec3& true_angular_velocity() const { return angular_velocity_; }  // [rad/s] world frame

 protected:
  /// Throws std::invalid_argument if a number is not usable (a mass that is not above zero, for
  /// example).
  HandDevice(const DeviceSpec& spec, const Hand& hand);

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
  Vec3 torque_ = Vec3::Zero();  // [N m] on the hand, held
  std::atomic<bool> released_{false};
};

}  // namespace feltwire

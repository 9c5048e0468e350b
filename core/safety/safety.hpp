#pragma once
// The safety stage: the last limits before a device. They protect the hand even if the bound is
// wrong or off.

#include <limits>

#include "core/base/types.hpp"
#include "core/bounding/velocity.hpp"

namespace feltwire {

/// Limits of one channel, force or torque. Infinity switches a limit off. Units: force / torque.
struct ChannelLimits {
  static constexpr double kOff = std::numeric_limits<double>::infinity();
  double max = kOff;   // [N] / [N m], > 0: largest magnitude
  double slew = kOff;  // [N/s] / [N m/s], > 0: fastest rise; falling is never limited
  /// [m/s] / [rad/s], > 0: up to this speed of the device the full command may be given. Above it
  /// the limit falls linearly to zero at twice this speed.
  double speed = kOff;
  double small = kOff;  // [N] / [N m], >= 0: ends the wait, see SafetyLimits
};

/// The limits of the stage. Each limit is off by default.
struct SafetyLimits {
  ChannelLimits force{}, torque{};
  /// [s], 0 to 10: after the first contact the share of the command that may be given grows
  /// linearly from 0 to 1 over this time. 0: no ramp.
  double ramp_up = 0.0;

  // Wait for small force. A device that connects inside an object must not be kicked: the hand
  // first moves it out. The wait lasts until the environment's command has once been at most
  // force.small and torque.small. During the wait only the part of the command above the floor is
  // given. The floor is the smallest command so far, so the force starts at zero and never jumps.
  // Each kFloorWay or kFloorTurn that the hand moves lowers the floor by `small`. So a field that
  // is never small (a magnet's tail, a constant force) is let in step by step, and a resting device
  // gets no force.
  static constexpr double kFloorWay = 5e-3;  // [m]
  static constexpr double kFloorTurn = 0.1;  // [rad]
};

/// Throws std::invalid_argument that names the limit, its value and the remedy.
void validate(const SafetyLimits& limits);

/// The input of one sample, in the world frame. Forces act on the hand.
struct SafetyStep {
  Command commanded;     // of the environment; ramp and speed limit a share of it
  bool original = true;  // `commanded` is the scene's, not reduced; only such a command ends a wait
  Command bounded;       // the command after the bound
  Vec3 displacement = Vec3::Zero();  // [m] since the last sample
  Vec3 rotation = Vec3::Zero();      // [rad] since the last sample; zero without actuated torque
  double hold_time = 0.0;            // [s] since the last sample
};

/// The limited command, and which limits reduced it.
struct Safeguarded {
  Command rendered;
  bool limited = false;   // max
  bool slewed = false;    // slew
  bool too_fast = false;  // speed
  bool ramped = false;    // ramp_up
  bool waiting = false;   // small: the wait took something off
  bool refused = false;   // an input was not finite: the command is zero
};

/// Scales the bounded command down to the smallest of the limits. Force and torque are scaled
/// separately, never up, and never turned. It reads no clock, allocates nothing and throws nothing.
///
/// A reduction is safe after a bound that limits magnitudes from above and gets the held force
/// (contact_frame, energy_tank), and where nothing is bounded (none). It is not safe behind
/// total_energy, per_axis and per_axis_projected, because they also bound a force from below. It is
/// not safe behind virtual_coupling and passivity control, because a reduced damper dissipates less
/// than they count on. admits_reduction() (core/bounding/bounding.hpp) tells which. `max` applies
/// to every mode, because every device has a largest force. The wait applies to every mode, too.
/// Behind modes that do not admit reductions (`reduces` false) it gives zero until the command has
/// been small: zero force is passive in every mode, a part of a force is not.
///
/// Ramp and speed limit the force to a share of the *command*, not of the bounded force. The
/// bounded force depends on the force held before. A share of it would shrink again at each sample,
/// and a hand at rest would soon feel nothing.
///
/// The speed limit is for a device that its own force throws out of the hand. A motor that goes on
/// pushing is what hurts, so the force is reduced in every direction. The limit falls over a
/// range and uses a low-passed speed. A threshold on plain encoder differences, which jump by a
/// quantum / T, would switch the force on and off from sample to sample.
class SafetyStage {
 public:
  /// Throws std::invalid_argument as validate() does.
  explicit SafetyStage(const SafetyLimits& limits = {}, bool reduces = true);

  /// Takes a servo sample. If its time is not above zero, ramp and slew do not advance.
  Safeguarded apply(const SafetyStep& step) noexcept;

  /// Forgets all state except the limits, for example after a lost connection. Wait and ramp begin
  /// again, and the slew limit starts from zero.
  void begin_anew() noexcept;

  /// Sets the force that the device really held, if it differs from `rendered`. The slew limit
  /// starts from it. A report that is not finite is ignored.
  void set_held(const Command& held) noexcept;

  const SafetyLimits& limits() const { return limits_; }
  /// True during the wait: the environment's command has not been small yet.
  bool waiting() const { return waiting_; }

 private:
  void wait(const SafetyStep& step, double force, double torque, double sinks) noexcept;
  void follow_ramp(double force, double torque, double time) noexcept;
  double ramp() const noexcept;
  void begin_wait() noexcept;

  SafetyLimits limits_;
  bool reduces_;
  VelocityEstimate velocity_, angular_velocity_;
  double held_force_ = 0.0, held_torque_ = 0.0;  // [N], [N m]
  bool waiting_ = false;
  double force_floor_ = 0.0, torque_floor_ = 0.0;  // [N], [N m] while waiting_
  bool touched_ = false;                           // the first contact has begun
  double since_touch_ = 0.0;                       // [s]
};

}  // namespace feltwire

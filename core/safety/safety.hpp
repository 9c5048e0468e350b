#pragma once
// The last stage before a device: what protects a hand, whatever the bound lets through.

#include <limits>

#include "core/base/types.hpp"
#include "core/bounding/velocity.hpp"

namespace feltwire {

/// Limits of one channel, force or torque; infinity switches each off. Units: force / torque.
struct ChannelLimits {
  static constexpr double kOff = std::numeric_limits<double>::infinity();
  double max = kOff;   // [N] / [N m], > 0: largest magnitude
  double slew = kOff;  // [N/s] / [N m/s], > 0: fastest rise; falling is never limited
  /// [m/s] / [rad/s], > 0: up to this speed of the device all that is commanded may be given,
  /// falling linearly to nothing at twice this speed.
  double speed = kOff;
  double small = kOff;  // [N] / [N m], >= 0: see SafetyLimits
};

/// The limits of the stage. Each is off unless set.
struct SafetyLimits {
  ChannelLimits force{}, torque{};
  /// [s], 0 to 10: from the first contact on, the share of the command that may be given grows
  /// linearly from nothing to all of it over this time. 0: all at once.
  double ramp_up = 0.0;

  // Wait for small force: a device that connects inside an object is not kicked; it is moved out by
  // its hand first. Until the environment's own command has once been at most force.small and
  // torque.small, only what exceeds the smallest command so far (the floor) is given: nothing at
  // first, and never a jump. Each kFloorWay or kFloorTurn that the hand moves takes `small` off the
  // floor, so that a field that is never small (a magnet's tail, a constant force) is let in, and a
  // device that rests is given nothing.
  static constexpr double kFloorWay = 5e-3;  // [m]
  static constexpr double kFloorTurn = 0.1;  // [rad]
};

/// Throws std::invalid_argument naming the limit, its value and the remedy.
void validate(const SafetyLimits& limits);

/// The input of one sample. Everything in the world frame, on the hand.
struct SafetyStep {
  Command commanded;     // the environment's; the shares of ramp and speed are shares of it
  bool original = true;  // nothing has been taken off `commanded` since the scene: it ends a wait
  Command bounded;       // what the bound lets through
  Vec3 displacement = Vec3::Zero();  // [m] since the last sample
  Vec3 rotation = Vec3::Zero();      // [rad] likewise; zero where torque is not actuated
  double hold_time = 0.0;            // [s] since the last sample
};

/// The limited command, and which limits reduced it.
struct Safeguarded {
  Command rendered;
  bool limited = false;   // max
  bool slewed = false;    // slew
  bool too_fast = false;  // speed
  bool ramped = false;    // ramp_up
  bool waiting = false;   // small: more would have been given
  bool refused = false;   // an input was not finite: nothing is given
};

/// Scales what the bound lets through down to the smallest of the limits; force and torque apart,
/// never up, never in another direction. A pure value: no clock, nothing allocated or thrown.
///
/// That is admissible behind a bound that limits magnitudes from above and is told what was held
/// (contact_frame, energy_tank), and where there is nothing to break (none). It is not behind
/// total_energy, per_axis and per_axis_projected, which bound a force from below too, nor behind
/// virtual_coupling and passivity control: a damper that is held back dissipates less than was
/// counted on. admits_reduction() (core/bounding/bounding.hpp) says which. `max` is for every mode,
/// for every device has one; so is the wait, but behind these modes (`reduces` false) it gives
/// nothing at all until the command has been small, for zero force is passive in every mode and a
/// part of a force is not.
///
/// Ramp and speed limit magnitudes to a share of the *command*, not of what the bound lets through:
/// that follows from the force held before, so a share of a share of a share would be left, nothing
/// after a few samples of a hand at rest.
///
/// The speed limit is for a device that its force throws out of the hand: a motor that goes on
/// pushing is what hurts, so force is lost whichever way it points. It falls off over a range and
/// sees a low-passed speed: a threshold on bare encoder differences, a quantum over T apart, would
/// switch the force on and off from sample to sample.
class SafetyStage {
 public:
  /// Throws std::invalid_argument as validate() does.
  explicit SafetyStage(const SafetyLimits& limits = {}, bool reduces = true);

  /// One servo sample. A time that is not above zero lets no ramp and no slew go on.
  Safeguarded apply(const SafetyStep& step) noexcept;

  /// Forgets everything but its limits, as after a connection that was lost: wait and ramp begin
  /// anew, a slew limit starts from nothing.
  void begin_anew() noexcept;

  /// Says what the device really held, where that differs from `rendered`: the slew limit starts
  /// from it. A report that is not finite is left out.
  void set_held(const Command& held) noexcept;

  const SafetyLimits& limits() const { return limits_; }
  /// Nothing is given yet: the environment has not yet asked for little.
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

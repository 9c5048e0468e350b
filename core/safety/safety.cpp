#include "core/safety/safety.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>
#include <string>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kLongestRamp = 10.0;  // [s] A longer ramp has a wrong unit.
// [Hz] Cutoff frequency of the speed filter. At 1 kHz, a quantum of 55 um then counts as 15 mm/s
// for a moment, and not as 55 mm/s. An acceleration of 10 m/s^2 is detected 3 ms late, when the
// device is 30 mm/s faster.
constexpr double kSpeedCutoff = 50.0;

void require(bool good, const char* channel, const char* name, double value, const char* must) {
  if (good) return;
  std::ostringstream message;
  message << channel << name << " = " << value << " must be " << must;
  throw std::invalid_argument(message.str());
}

void check(const ChannelLimits& c, const char* channel) {
  constexpr auto kPositive = "above zero; infinity switches it off";
  require(c.max > 0.0, channel, "max", c.max, kPositive);
  require(c.slew > 0.0, channel, "slew", c.slew, kPositive);
  require(c.speed > 0.0, channel, "speed", c.speed, kPositive);
  require(c.small >= 0.0, channel, "small", c.small, "zero or more; infinity switches it off");
}

/// Returns true if the command and the sum of its two forces are finite.
bool usable(const Command& c) { return c.finite() && c.force().allFinite(); }

/// Returns true if a movement and its velocity are finite.
bool usable(const Vec3& movement, double time) {
  return movement.allFinite() && (!(time > 0.0) || (movement / time).allFinite());
}

/// Returns the share of the command for this speed: 1 up to the limit, and 0 from twice the limit
/// on.
double share_at(double speed, double limit) {
  return std::isfinite(limit) ? std::clamp(2.0 - speed / limit, 0.0, 1.0) : 1.0;
}

/// Reduces a command to the smallest limit. Sets the flag in `who` for each limit that the command
/// exceeds.
struct Reduction {
  const ChannelLimits& limits;
  double commanded, held;  // magnitudes of the command and of the last force [N] or [N m]
  double floor;            // magnitude [N] or [N m] that is withheld from the command
  double ramp, speed;      // share that the ramp allows; speed of the device
  double time;             // [s] since the last sample

  double factor(double bounded, Safeguarded& who) const noexcept {
    double allowed = bounded;
    const auto limit = [&](double most, bool& flag) {
      if (!(bounded > most)) return;
      flag = true;
      allowed = std::min(allowed, most);
    };
    if (floor > 0.0) limit(std::max(0.0, commanded - floor), who.waiting);
    if (!(allowed > 0.0)) return 0.0;  // Nothing is left to reduce.
    limit(limits.max, who.limited);
    if (std::isfinite(limits.slew)) limit(held + limits.slew * time, who.slewed);
    if (ramp < 1.0) limit(ramp * commanded, who.ramped);
    const double share = share_at(speed, limits.speed);
    if (share < 1.0) limit(share * commanded, who.too_fast);
    return allowed < bounded ? allowed / bounded : 1.0;
  }
};

}  // namespace

void validate(const SafetyLimits& limits) {
  check(limits.force, "force.");
  check(limits.torque, "torque.");
  require(limits.ramp_up >= 0.0 && limits.ramp_up <= kLongestRamp, "", "ramp_up", limits.ramp_up,
          "from 0 to 10 s; 0 gives all at once");
}

SafetyStage::SafetyStage(const SafetyLimits& limits, bool reduces)
    : limits_(limits), reduces_(reduces), velocity_(kSpeedCutoff), angular_velocity_(kSpeedCutoff) {
  validate(limits);
  begin_wait();
}

/// Starts the wait, in which a part of the command (the floor) is withheld. The floor is zero for a
/// channel (force or torque) without a wait, and otherwise still unknown.
void SafetyStage::begin_wait() noexcept {
  constexpr double kUnknown = ChannelLimits::kOff;
  const auto floor_of = [](double small) { return std::isfinite(small) ? kUnknown : 0.0; };
  force_floor_ = floor_of(limits_.force.small);
  torque_floor_ = floor_of(limits_.torque.small);
  waiting_ = force_floor_ > 0.0 || torque_floor_ > 0.0;
}

/// Lowers the floor of each channel by `sinks` times the small limit. The end of the wait depends
/// on the environment's command, not on the reduced command.
void SafetyStage::wait(const SafetyStep& step, double force, double torque, double sinks) noexcept {
  const auto follow = [&](double& floor, double magnitude, double small) {
    if (!(floor > 0.0)) return true;
    floor = std::max(0.0, floor - sinks * small);
    if (step.original) floor = std::min(floor, magnitude);
    return floor <= small;
  };
  bool over = step.original && force <= limits_.force.small && torque <= limits_.torque.small;
  if (reduces_) {
    const bool force_small = follow(force_floor_, force, limits_.force.small);
    over = follow(torque_floor_, torque, limits_.torque.small) && force_small;
  }
  if (!over) return;
  waiting_ = false;
  force_floor_ = torque_floor_ = 0.0;
}

/// Counts the time since the first touch. The limits of the ramp rise with this time.
void SafetyStage::follow_ramp(double force, double torque, double time) noexcept {
  if (touched_)
    since_touch_ += time;
  else
    touched_ = force > force_floor_ || torque > torque_floor_;
}

double SafetyStage::ramp() const noexcept {
  return since_touch_ < limits_.ramp_up ? since_touch_ / limits_.ramp_up : 1.0;
}

Safeguarded SafetyStage::apply(const SafetyStep& step) noexcept {
  Safeguarded result;
  if (!std::isfinite(step.hold_time) || !usable(step.bounded) || !usable(step.commanded) ||
      !usable(step.displacement, step.hold_time) || !usable(step.rotation, step.hold_time))
      [[unlikely]] {
    result.refused = true;
    set_held({});
    return result;
  }
  const double time = std::max(step.hold_time, 0.0);
  const double speed = length(velocity_.update(step.displacement, time));
  const double angular_speed = length(angular_velocity_.update(step.rotation, time));
  const double force = length(step.commanded.force()), torque = length(step.commanded.torque);
  if (waiting_)
    wait(step, force, torque,
         time * (speed / SafetyLimits::kFloorWay + angular_speed / SafetyLimits::kFloorTurn));
  follow_ramp(force, torque, time);

  const double given_force = length(step.bounded.force());
  const double given_torque = length(step.bounded.torque);
  if (waiting_ && !reduces_) {
    result.waiting = given_force > 0.0 || given_torque > 0.0;
    set_held({});
    return result;
  }
  const double force_factor =
      Reduction{limits_.force, force, held_force_, force_floor_, ramp(), speed, time}.factor(
          given_force, result);
  const double torque_factor =
      Reduction{limits_.torque, torque, held_torque_, torque_floor_, ramp(), angular_speed, time}
          .factor(given_torque, result);
  result.rendered = {force_factor * step.bounded.elastic, force_factor * step.bounded.frictional,
                     torque_factor * step.bounded.torque};
  set_held(result.rendered);
  return result;
}

void SafetyStage::begin_anew() noexcept {
  velocity_ = VelocityEstimate(kSpeedCutoff);
  angular_velocity_ = VelocityEstimate(kSpeedCutoff);
  held_force_ = held_torque_ = 0.0;
  begin_wait();
  touched_ = false;
  since_touch_ = 0.0;
}

void SafetyStage::set_held(const Command& held) noexcept {
  if (!held.finite()) return;
  held_force_ = length(held.force());
  held_torque_ = length(held.torque);
}

}  // namespace feltwire

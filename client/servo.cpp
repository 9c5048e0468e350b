#include "client/servo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "core/numeric.hpp"

namespace feltwire {
namespace {

// Samples remembered for their reply: 8 s at 1 kHz, 0.8 s at 10 kHz. A later reply still counts as
// answered and late.
constexpr std::size_t kRemembered = 8192;
constexpr double kSmallestForce = 1e-6;  // [N] below it a force has no direction worth measuring

double seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

BoundingConfig bound_of(const SessionParameters& parameters, const DeviceSpec& spec) {
  validate(spec);
  validate(parameters);
  BoundingConfig config = bounding_config(parameters, spec);
  // The server bounds: what stays here are the safety clamps, which every mode has.
  if (parameters.side == BoundingSide::server) config.mode = BoundingMode::none;
  return config;
}

PortEnergy observer_of(const BoundingConfig& config) {
  return {config.damping, config.rotation ? config.rotational_damping : Damping(), config.period};
}

void refuse_beside(BoundingMode mode, const char* what, double value, const char* unit,
                   double off) {
  if (value == off) return;
  std::ostringstream message;
  message << "a " << what << " of " << value << " " << unit << " cannot follow the bounding mode "
          << name(mode) << ", which also bounds forces from below; use "
          << "contact_frame or no " << what << " (" << off << ")";
  throw std::invalid_argument(message.str());
}

bool good(const DeviceReading& reading) {
  const Quaternion& q = reading.pose.orientation;
  return reading.ok && reading.pose.position.allFinite() && q.coeffs().allFinite() &&
         q.squaredNorm() > 0.0;
}

}  // namespace

void validate(const ServoOptions& options, const SessionParameters& parameters) {
  const SafetyLimits& s = options.safety;
  validate(s);
  if (admits_reduction(parameters.mode)) return;
  refuse_beside(parameters.mode, "slew limit", s.force.slew, "N/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "slew limit", s.torque.slew, "N m/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "velocity limit", s.force.speed, "m/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "velocity limit", s.torque.speed, "rad/s", ChannelLimits::kOff);
  refuse_beside(parameters.mode, "ramp-up", s.ramp_up, "s", 0.0);
}

ServoOptions protect_hand(const SessionParameters& parameters) {
  ServoOptions options;
  options.safety.force.small = 0.05;   // [N] below what a resting hand feels
  options.safety.torque.small = 2e-3;  // [N m] the same at an arm of 40 mm
  if (!admits_reduction(parameters.mode)) return options;
  options.safety.force.speed = 1.5;  // [m/s]
  // A bound lets nothing through at first either, and what a ramp withheld behind it comes back
  // only as the hand presses deeper (measured).
  const bool client_bounds =
      parameters.side != BoundingSide::server && parameters.mode != BoundingMode::none;
  if (!client_bounds) options.safety.ramp_up = 0.2;  // [s]
  return options;
}

Servo::Servo(const DeviceSpec& spec, const SessionParameters& parameters,
             const ServoOptions& options)
    : spec_(spec),
      parameters_(parameters),
      options_(options),
      bounding_(bound_of(parameters, spec)),
      safety_(options.safety),
      port_(observer_of(bounding_.config())),
      torque_(bounding_.config().rotation),
      period_(bounding_.config().period),
      sent_(kRemembered) {
  validate(options, parameters);
}

bool Servo::take(const Reply& reply, Nanoseconds arrival) noexcept {
  // An answer to what was never asked would lock out every true one after it.
  if (reply.sample_index == 0 || reply.sample_index > sample_.index) {
    ++statistics_.replies_refused;
    return false;
  }
  count_answer(reply, arrival);
  if (reply.sample_index <= newest_.sample_index) {
    ++statistics_.replies_stale;
    return false;
  }
  newest_ = reply;
  newest_arrival_ = arrival;
  // What the server's bound has changed says nothing of how deep the hand is: at the first sample
  // it lets nothing through, inside an object too.
  newest_original_ = reply.command.finite() && !reply.active && !reply.saturated && !reply.refused;
  if (!reply.command.finite()) {
    ++statistics_.replies_refused;
    newest_.command = {};
  }
  return true;
}

void Servo::count_answer(const Reply& reply, Nanoseconds arrival) noexcept {
  const std::uint64_t index = reply.sample_index;
  Sent& sent = sent_[index % kRemembered];
  if (sent.index != index) {  // so old that its place is taken
    ++statistics_.answered;
    ++statistics_.late;
    return;
  }
  if (sent.answered) return;
  sent.answered = true;
  const Nanoseconds round_trip = arrival - sent.time;
  ++statistics_.answered;
  if (round_trip > kLate) ++statistics_.late;
  statistics_.round_trip.record(round_trip.count());
  server_clock_.take({sent.time, reply.server_receive_time, reply.server_send_time, arrival});
}

double Servo::fade_factor() const noexcept {
  const double half = 0.5 * parameters_.hold_time;
  return std::clamp((parameters_.hold_time - command_age_) / half, 0.0, 1.0);
}

/// The movement since the last tick. Across a fault it is unknown, so none is credited: the storage
/// of the force that was held covers the worst of it (bounding.md), and that force has become zero.
Servo::Movement Servo::moved_to(const DeviceReading& reading) noexcept {
  Movement moved;
  if (position_known_) {
    moved.displacement = reading.pose.position - sample_.pose.position;
    if (torque_)
      moved.rotation = rotation_between(sample_.pose.orientation, reading.pose.orientation);
  }
  sample_.pose = reading.pose;
  sample_.pose.orientation.normalize();
  position_known_ = posed_ = true;
  return moved;
}

Command Servo::safeguard(const Command& bounded, const BoundingStep& step) noexcept {
  const Safeguarded safe = safety_.apply({.commanded = wanted_,
                                          .original = position_known_ && newest_original_,
                                          .bounded = actuated(spec_, bounded),
                                          .displacement = step.displacement,
                                          .rotation = step.rotation,
                                          .hold_time = step.hold_time});
  statistics_.waiting += safe.waiting ? 1 : 0;
  statistics_.ramped += safe.ramped ? 1 : 0;
  statistics_.slewed += safe.slewed ? 1 : 0;
  statistics_.too_fast += safe.too_fast ? 1 : 0;
  statistics_.force_limited += safe.limited ? 1 : 0;
  return safe.rendered;
}

Command Servo::render(const DeviceReading& reading, Nanoseconds now) noexcept {
  const double hold_time = ticked_ ? seconds(now - last_tick_) : period_;
  ticked_ = true;
  last_tick_ = now;
  sample_.client_time = now;
  command_age_ = has_reply() ? seconds(now - newest_arrival_) : 0.0;
  if (reading.ended) device_ended_ = released_ = true;

  BoundingStep step;
  step.hold_time = hold_time;
  const bool usable = good(reading);
  if (usable) {
    const Movement moved = moved_to(reading);
    step.displacement = moved.displacement;
    step.rotation = moved.rotation;
    port_.step(held_, moved.displacement, moved.rotation, hold_time);
  } else {
    ++statistics_.device_faults;
    position_known_ = false;
  }

  wanted_ = {};
  if (usable && !released_ && has_reply()) {
    // Only what the device can do goes into the bound, so that it accounts what it gives.
    wanted_ = actuated(spec_, newest_.command);
    const double factor = fade_factor();
    if (factor < 1.0) ++statistics_.faded;
    step.command = factor * wanted_;
  }

  const Bounded bounded = bounding_.step(step);
  statistics_.bound_active += bounded.active ? 1 : 0;
  statistics_.saturated += bounded.saturated ? 1 : 0;
  statistics_.refused += bounded.refused ? 1 : 0;

  return safeguard(bounded.rendered, step);
}

const Sample* Servo::hold(const Command& held) noexcept {
  held_ = held;
  if (!held.finite()) {
    ++statistics_.device_faults;
    held_ = {};
  }
  bounding_.set_held(held_);
  safety_.set_held(held_);
  statistics_.max_force = std::max(statistics_.max_force, length(held_.force()));
  observe_direction(held_);
  if (!posed_) return nullptr;

  sample_.held = held_;
  ++sample_.index;
  ++statistics_.samples;
  sent_[sample_.index % kRemembered] = {sample_.index, sample_.client_time, false};
  return &sample_;
}

void Servo::observe_direction(const Command& held) noexcept {
  const Vec3 given = held.force();
  const Vec3 wanted = wanted_.force();
  if (!(length(given) > kSmallestForce) || !(length(wanted) > kSmallestForce)) return;
  const Vec3 u = direction(given), v = direction(wanted);
  // Right for every angle; the arc cosine loses half the digits near zero.
  const double angle = 2.0 * std::atan2((u - v).norm(), (u + v).norm());
  constexpr double kMicrodegrees = 1e6 * 180.0 / std::numbers::pi;
  statistics_.direction_error.record(std::llround(kMicrodegrees * angle));
}

}  // namespace feltwire

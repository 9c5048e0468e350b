#include "client/servo/servo.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

// Samples remembered for their reply: 8 s at 1 kHz, 0.8 s at 10 kHz. A later reply still counts as
// answered and late.
constexpr std::size_t kRemembered = 8192;
constexpr double kSmallestForce = 1e-6;  // [N] below it a force has no direction worth measuring

bool admits_reduction(const SessionParameters& parameters) {
  return bounding_method(parameters.mode).admits_reduction;
}

BoundingConfig bound_of(const SessionParameters& parameters, const DeviceSpec& spec) {
  validate(spec);
  validate(parameters);
  BoundingConfig config = bounding_config(parameters, spec);
  // The server bounds: what stays here are the safety clamps, which every mode has.
  if (parameters.side == BoundingSide::server) config.mode = kUnbounded;
  return config;
}

/// Where the server bounds, for its bound knows nothing of delay, of loss and of late ticks; and
/// behind a bound at this side that may be reduced, for that one counts on holds of T. None where
/// nothing bounds, where no damping of the device is known, and where this side's bound was told to
/// credit the operator, which the guard does not.
std::optional<PortGuard> guard_of(const SessionParameters& parameters, const DeviceSpec& spec) {
  const bool behind_bound = parameters.side != BoundingSide::server;
  if (parameters.mode == kUnbounded || !PortGuard::usable(spec.damping) ||
      (behind_bound && (!admits_reduction(parameters) || parameters.operator_damping > 0.0)))
    return std::nullopt;
  return PortGuard(spec.damping, spec.rotation_actuated > 0 ? spec.rotational_damping : Damping());
}

/// Of what the device burns by itself: whatever the bound is told to credit, that is the truth.
PortEnergy observer_of(const DeviceSpec& spec, double period) {
  return {spec.damping, spec.rotation_actuated > 0 ? spec.rotational_damping : Damping(), period};
}

/// Nothing else withholds what a scene changes to, and nothing else sees to it that it is paid for.
std::optional<Admission> admission_of(const SessionParameters& p, const DeviceSpec& spec,
                                      const Bounding& bounding,
                                      const std::optional<PortGuard>& guard) {
  if (!bounding.takes_endowment() || !guard) return std::nullopt;
  return Admission(spec.max_force / (0.5 * p.hold_time));
}

void refuse_beside(std::string_view mode, const char* what, double value, const char* unit,
                   double off) {
  if (value == off) return;
  std::ostringstream message;
  message << "a " << what << " of " << value << " " << unit << " cannot follow the bounding mode "
          << mode << ", which also bounds forces from below; use "
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
  if (admits_reduction(parameters)) return;
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
  if (!admits_reduction(parameters)) return options;
  options.safety.force.speed = 1.5;  // [m/s]
  // A bound lets nothing through at first either, and what a ramp withheld behind it comes back
  // only as the hand presses deeper (measured).
  const bool client_bounds =
      parameters.side != BoundingSide::server && parameters.mode != kUnbounded;
  if (!client_bounds) options.safety.ramp_up = 0.2;  // [s]
  return options;
}

Servo::Servo(const DeviceSpec& spec, const SessionParameters& parameters,
             const ServoOptions& options)
    : spec_(spec),
      parameters_(parameters),
      options_(options),
      bounding_(bound_of(parameters, spec)),
      safety_(options.safety, admits_reduction(parameters)),
      port_(observer_of(spec, parameters.servo_period)),
      guard_(guard_of(parameters, spec)),
      reserve_(parameters.servo_period),
      admission_(admission_of(parameters, spec, bounding_, guard_)),
      torque_(bounding_.config().rotation),
      period_(bounding_.config().period),
      measures_(bounding_.config().period),
      velocity_(parameters.velocity_cutoff),
      sent_(kRemembered) {
  validate(options, parameters);
}

void Servo::release() noexcept {
  released_ = true;
  start_letting_go();
}

void Servo::reconnected(bool fresh) noexcept {
  if (fresh) withheld_before_ = statistics_.withheld;
  if (fresh) fresh_ = true;
  if (released_) return;
  if (pulls(held_))
    start_letting_go();
  else
    begin_anew(sample_.index);
}

void Servo::start_letting_go() noexcept {
  if (letting_go_) return;
  letting_go_ = true;
  let_go_from_ = last_tick_;
}

void Servo::begin_anew(std::uint64_t last_sample_before) noexcept {
  safety_.begin_anew();
  local_.clear();
  if (admission_) admission_->forget();
  anew_after_ = last_sample_before;
  newest_original_ = false;  // what was said before says nothing of where the hand is now
}

/// [s]; the period where the clock says that none has passed.
double Servo::time_since_last_tick(Nanoseconds now) noexcept {
  if (!ticked_) return period_;
  const Nanoseconds elapsed = now - last_tick_;
  if (elapsed.count() < 0) {  // set back: what is remembered moves with it, and ages by a tick
    newest_arrival_ += elapsed - from_seconds(period_);
    newest_sampled_ += elapsed - from_seconds(period_);
    let_go_from_ += elapsed - from_seconds(period_);
    return period_;
  }
  if (seconds(elapsed) > parameters_.hold_time) stood_still_after_ = sample_.index;
  return seconds(elapsed);
}

double Servo::fade_factor() const noexcept {
  const double half = 0.5 * parameters_.hold_time;
  const double by_age = std::clamp((parameters_.hold_time - command_age_) / half, 0.0, 1.0);
  if (!letting_go_) return by_age;
  return std::clamp(1.0 - seconds(last_tick_ - let_go_from_) / half, 0.0, by_age);
}

/// Never more than the device can do is faded, or a command far beyond it would be gone in a step.
Command Servo::faded(const Command& command, double factor) const noexcept {
  if (!(factor < 1.0)) return command;
  const double force = length(command.force()), torque = length(command.torque);
  const double most_force = bounding_.config().max_force;
  const double most_torque = bounding_.config().max_torque;
  const double of_force = force > most_force ? factor * (most_force / force) : factor;
  const double of_torque = torque > most_torque ? factor * (most_torque / torque) : factor;
  return {of_force * command.elastic, of_force * command.frictional, of_torque * command.torque};
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

Command Servo::safeguard(const Command& bounded, const BoundingStep& step, bool original) noexcept {
  const Safeguarded safe = safety_.apply({.commanded = wanted_,
                                          .original = position_known_ && original,
                                          .bounded = actuated(spec_, bounded),
                                          .displacement = step.displacement,
                                          .rotation = step.rotation,
                                          .hold_time = step.hold_time});
  trail_.stage_waits = safety_.waiting();
  trail_.refused |= safe.refused;
  trail_.too_fast = safe.too_fast;
  trail_.ramped = safe.ramped;
  trail_.slewed = safe.slewed;
  trail_.limited = safe.limited;
  trail_.safe = safe.rendered;
  statistics_.waiting += safe.waiting ? 1 : 0;
  statistics_.ramped += safe.ramped ? 1 : 0;
  statistics_.slewed += safe.slewed ? 1 : 0;
  statistics_.too_fast += safe.too_fast ? 1 : 0;
  statistics_.force_limited += safe.limited ? 1 : 0;
  return safe.rendered;
}

/// Asks the local model at the device's position; what it does not know of stays the reply's, given
/// as `command`. True when the model spoke alone.
bool Servo::follow_model(const BoundingStep& step, Nanoseconds now, Command& command) noexcept {
  const Vec3& velocity = velocity_.update(step.displacement, step.hold_time);
  const double age = seconds(now - model_time_);
  const LocalForce force = local_.touch({sample_.pose.position, velocity}, age, step.hold_time);
  const double w = force.weight;
  command.elastic = w * force.command.elastic + (1.0 - w) * command.elastic;
  command.frictional = w * force.command.frictional + (1.0 - w) * command.frictional;
  environment_ = command;
  ++(w >= 1.0  ? statistics_.modelled
     : w > 0.0 ? statistics_.half_modelled
               : statistics_.beyond_model);
  return w >= 1.0;
}

/// Of a scene that was changed, what the hand has paid for.
void Servo::let_in(const BoundingStep& step) noexcept {
  const double energy = admission_->energy({.held = held_,
                                            .displacement = step.displacement,
                                            .hold_time = reserve_.hold_time(),
                                            .command = step.command,
                                            .margin = port_.margin()},
                                           *guard_);
  // Elastic storage has kept what was pressed; it would have it twice.
  if (energy > 0.0 && parameters_.storage != Storage::elastic) bounding_.endow(energy);
}

Command Servo::render(const DeviceReading& reading, Nanoseconds now) noexcept {
  BoundingStep step;
  step.hold_time = time_since_last_tick(now);
  ticked_ = true;
  last_tick_ = now;
  sample_.client_time = now;
  command_age_ = has_reply() ? seconds(now - newest_arrival_) : 0.0;
  if (reading.ended) device_ended_ = released_ = true;

  reserve_.saw(step.hold_time);
  const bool read = good(reading), usable = read && !device_ended_;
  trail_ = {.observer = options_.observes,
            .device_ended = device_ended_,
            .released = released_,
            .letting_go = letting_go_,
            .read = read,
            .answered = has_reply(),
            .silent = !(command_age_ < parameters_.hold_time),
            .recovering = newest_.recovering,
            .server_bound = newest_.active || newest_.saturated || newest_.refused};
  if (read) {
    const Movement moved = moved_to(reading);
    step.displacement = moved.displacement;
    step.rotation = moved.rotation;
    displacement_ = moved.displacement;
    port_.step(held_, moved.displacement, moved.rotation, step.hold_time);
  } else {
    ++statistics_.device_faults;
    position_known_ = false;
    measures_.lose();
    begin_anew(sample_.index + (posed_ ? 1 : 0));  // this tick's sample has the old position
  }

  wanted_ = {};
  double factor = 0.0;  // of the command
  bool original = newest_original_;
  if (usable && has_reply()) {
    Command environment = reconstructed(now);
    if (parameters_.local_model && follow_model(step, now, environment)) original = true;
    // Only what the device can do goes into the bound, so that it accounts what it gives.
    wanted_ = actuated(spec_, environment);
    factor = fade_factor();
    if (factor < 1.0) ++statistics_.faded;
    step.command = faded(wanted_, factor);
    trail_.asked = environment;
    trail_.actuated = wanted_;
    trail_.faded = step.command;
  }

  if (admission_) let_in(step);
  Bounded bounded = bounding_.step(step);
  if (admission_) admission_->given(bounded.rendered.elastic, step.command.elastic);
  // The paper's laws would hold on to a part of the last force; zero is passive too.
  if (!(factor > 0.0)) bounded.rendered = {};
  statistics_.bound_active += bounded.active ? 1 : 0;
  statistics_.saturated += bounded.saturated ? 1 : 0;
  statistics_.refused += bounded.refused ? 1 : 0;

  trail_.bounded = bounded.rendered;
  trail_.refused = bounded.refused;
  Command given = safeguard(bounded.rendered, step, original);
  if (guard_) {
    const Command affordable = guard_->apply(given, port_.margin(), reserve_.hold_time());
    statistics_.guarded += affordable == given ? 0 : 1;
    given = affordable;
  }
  trail_.guarded = given;
  if (letting_go_ && !released_ && !(factor > 0.0)) {
    letting_go_ = false;
    newest_.command = {};
    newest_.predicted = false;
    begin_anew(sample_.index);
  }
  return given;
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
  explain(held_);
  if (!posed_) return nullptr;

  sample_.held = held_;
  ++sample_.index;
  ++statistics_.samples;
  sent_[sample_.index % kRemembered] = {sample_.index, sample_.client_time, 0, false};
  return &sample_;
}

void Servo::explain(const Command& held) noexcept {
  trail_.held = held;
  no_force_ = why_no_force(trail_);
  ++statistics_.no_force[static_cast<std::size_t>(no_force_)];
  if (position_known_) measures_.take(displacement_, wanted_.elastic, held.force());
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

#include "client/servo/servo.hpp"

#include <algorithm>

#include "core/base/numeric.hpp"

namespace feltwire {

Servo::Servo(const DeviceSpec& spec, const SessionParameters& parameters,
             const ServoOptions& options)
    : spec_(spec),
      options_(options),
      law_(spec, parameters, options),
      input_(spec, options.motion_scale, law_.law().bounding.config().rotation,
             parameters.servo_period),
      replies_(parameters.servo_period, options.leads.has_value()),
      environment_(spec, parameters, options),
      explanation_(parameters.servo_period) {
  validate(options, parameters);
}

bool Servo::take(const Reply& reply, Nanoseconds arrival) noexcept {
  const double hold_time = parameters().hold_time;
  const ReplyIntake::Taken taken = replies_.take(
      reply, arrival, {sample_.index, last_tick_, fade_.ending()}, hold_time, statistics_.replies);
  if (taken.scene_changed) law_.scene_changed();
  if (taken.used && parameters().local_model)
    environment_.take(replies_, sample_.index, hold_time, statistics_.local_model);
  return taken.newest;
}

const Sample* Servo::tick(Device& device, Nanoseconds now) noexcept {
  const DeviceReading reading = device.read(now);
  const double patience = kDevicePatience * parameters().hold_time;
  if (input_.waits(reading, seconds(now - last_tick_), patience, statistics_.device))
    return nullptr;
  return hold(device.write(render(reading, now)));
}

Command Servo::render(const DeviceReading& reading, Nanoseconds now) noexcept {
  BoundingStep step;
  step.hold_time = time_since_last_tick(now);
  ticked_ = true;
  last_tick_ = now;
  sample_.client_time = now;
  command_age_ = replies_.age(now);
  released_ = released_ || reading.ended;

  RobotLead* const robot = environment_.robot();
  if (robot != nullptr) robot->take(reading, !released_ && !overdraft(), options_);
  const DeviceMovement movement = input_.take(reading, step.hold_time, statistics_.device);
  begin_trail(reading, movement);
  sample_.pose = input_.pose();
  step.displacement = movement.displacement;
  step.rotation = movement.rotation;
  if (movement.read) {
    law_.moved(reading, movement, step.hold_time, statistics_.device);
    if (robot != nullptr)
      law_.credit(robot->hand().step(sample_.pose.position, movement.displacement, held().force(),
                                     step.hold_time));
  } else {
    explanation_.lose();
    begin_anew(sample_.index +
               (input_.posed() ? 1 : 0));  // this tick's sample has the old position
  }
  law_.saw(step, movement.known);

  const ForceLaw::Asked asked = ask(step, movement, now);
  given_ = law_.apply(step, asked, explanation_.trail(), statistics_.law);
  tick_ = {.displacement = movement.displacement,
           .wanted = asked.wanted,
           .elapsed = step.hold_time,
           .known = movement.read};
  if (fade_.ending() && !released_ && !(asked.share > 0.0)) end_fade();
  if (overdraft()) given_ = {};
  return given_;
}

const Sample* Servo::hold(const Command& held) noexcept {
  if (!held.finite()) ++statistics_.device.faults;
  law_.hold(given_, held);
  environment_.held(law_.held());
  tick_.held = law_.held();
  tick_.released = released_;
  tick_.feels_scene = feels_scene();
  explanation_.take(tick_, statistics_);
  if (!input_.posed()) return nullptr;

  sample_.held = law_.held();
  ++sample_.index;
  ++statistics_.samples;
  replies_.made(sample_.index, sample_.client_time);
  return &sample_;
}

/// Returns the time since the last tick [s]. Returns the period at the first tick, and after the
/// clock was set back.
double Servo::time_since_last_tick(Nanoseconds now) noexcept {
  const double period = parameters().servo_period;
  if (!ticked_) return period;
  const Nanoseconds elapsed = now - last_tick_;
  if (elapsed.count() < 0) {  // the clock was set back: shift the remembered times
    replies_.move_times(elapsed - from_seconds(period));
    fade_.move_times(elapsed - from_seconds(period));
    return period;
  }
  if (seconds(elapsed) > parameters().hold_time) replies_.stood_still(sample_.index);
  return seconds(elapsed);
}

void Servo::begin_trail(const DeviceReading& reading, const DeviceMovement& movement) noexcept {
  const Reply& reply = replies_.newest();
  explanation_.trail() = {.observer = options_.observes,
                          .released = released_,
                          .letting_go = fade_.ending(),
                          .law_change = law_.changes(),
                          .overdrawn = overdraft().has_value(),
                          .device = {.ended = input_.ended(),
                                     .usable = movement.read,
                                     .jumped = movement.jumped,
                                     .clutched = reading.ok && reading.clutched,
                                     .withheld = reading.ok ? reading.withheld : Withheld::nothing},
                          .reply = {.answered = has_reply(),
                                    .silent = !(command_age_ < parameters().hold_time),
                                    .recovering = reply.recovering,
                                    .server_bound = reply.bound.active || reply.bound.saturated ||
                                                    reply.bound.refused}};
}

/// Sets step.command to the scene's command, reduced by the fade. Returns the scene's command and
/// its properties.
ForceLaw::Asked Servo::ask(BoundingStep& step, const DeviceMovement& movement,
                           Nanoseconds now) noexcept {
  ForceLaw::Asked asked{.original = replies_.original(), .movement_known = movement.known};
  if (!movement.read || input_.ended() || !has_reply() || overdraft()) {
    environment_.idle();
    return asked;
  }
  const BoundingConfig& bound = law_.law().bounding.config();
  const Command scene = environment_.command(step, law_.law().bounding, sample_.pose, replies_,
                                             parameters(), now, statistics_.local_model);
  // The device cannot give every force, so bound only the force that it can give.
  asked.wanted = actuated(spec_, scene);
  asked.share = fade_.step(now, command_age_, step.hold_time, parameters().hold_time);
  // The force has faded to zero because answers are missing, and the hand has moved since. So start
  // as after a lost session.
  if (fade_.silent()) begin_anew(sample_.index);
  // `original`: the command shows the true force of the scene, so the safety limits may start with
  // it.
  asked.original = asked.share > 0.0 && (replies_.original() || near());
  if (asked.share < 1.0) ++statistics_.faded;
  step.command = faded(asked.wanted, asked.share, bound.max_force, bound.max_torque);
  ForceTrail& trail = explanation_.trail();
  trail.command.asked = scene;
  trail.command.actuated = asked.wanted;
  trail.command.faded = step.command;
  if (near() && shapes()) step.command = environment_.rise_limited(step, replies_);
  return asked;
}

void Servo::release() noexcept {
  released_ = true;
  fade_.begin(last_tick_);
}

void Servo::reconnected(bool fresh) noexcept {
  if (fresh) replies_.another_session(statistics_.replies);
  if (released_) return;
  if (law_.holds()) {
    found_again_ = true;
    fade_.begin(last_tick_);
  } else {
    begin_anew(sample_.index);
  }
}

void Servo::adopt(ServoLaw& next) noexcept {
  law_.adopt(next);
  if (law_.holds())
    fade_.begin(last_tick_);
  else
    exchange_law();
}

/// Restarts the force law and the environment for a hand at an unknown place. Answers to samples up
/// to `last_sample_before` do not show the hand's present depth.
void Servo::begin_anew(std::uint64_t last_sample_before) noexcept {
  law_.begin_anew();
  law_.forget_contact();
  environment_.forget();
  replies_.begin_anew(last_sample_before);
}

/// Ends a fade that has reached zero force. Also drops the force that the force bound still gives.
void Servo::end_fade() noexcept {
  fade_.end();
  replies_.forget_command();
  if (found_again_) begin_anew(sample_.index);
  found_again_ = false;
  given_ = {};
  if (changes_law()) exchange_law();
}

void Servo::exchange_law() noexcept {
  law_.exchange();
  environment_.law_changed();
  environment_.forget();
  replies_.forget_command();
}

/// Returns whether this tick renders the scene without fades and start limits. Only the force
/// bound, the energy account and the device limits may change the command.
bool Servo::feels_scene() const noexcept {
  const ForceTrail& trail = explanation_.trail();
  return tick_.known && !released_ && !fade_.ending() && fade_.share() >= 1.0 &&
         !trail.safety.waits && !trail.safety.ramped && !trail.reply.recovering &&
         !withholds_change();
}

std::optional<Servo::DeviceTrouble> Servo::device_trouble() const noexcept {
  const double patience = kDevicePatience * parameters().hold_time;
  if (!input_.ended() && input_.no_position_for() >= patience)
    return DeviceTrouble{ZeroForceReason::device_fault, input_.no_position_for()};
  if (explanation_.not_held_for() >= patience)
    return DeviceTrouble{ZeroForceReason::not_held, explanation_.not_held_for()};
  return std::nullopt;
}

std::optional<Lead> Servo::lead() const noexcept {
  if (environment_.robot() == nullptr) return std::nullopt;
  return environment_.robot()->lead();
}

HandReport Servo::report() const noexcept {
  HandReport report;
  report.reasons = explanation_.reasons({.near = near(),
                                         .shapes = shapes(),
                                         .fades = fade_.ending(),
                                         .law_changes = changes_law(),
                                         .released = released_,
                                         .in_debt = overdraft() || is_debt(-owed()),
                                         .withholds_change = withholds_change(),
                                         .on_time = spec_.actuation.late_ticks == 0});
  report.has_account = account().has_value();
  report.balance = account() ? account()->balance() : 0.0;
  report.round_trip = replies_.round_trip();
  report.hand_damping = hand_credit() ? hand_credit()->damping : 0.0;
  return report;
}

}  // namespace feltwire

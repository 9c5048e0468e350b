#include "client/servo/servo.hpp"

#include <algorithm>
#include <cmath>
#include <limits>
#include <numbers>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kSmallestForce = 1e-6;  // [N] below it a force has no direction worth measuring

bool good(const DeviceReading& reading) {
  const Quaternion& q = reading.pose.orientation;
  return reading.ok && reading.fresh && !reading.clutched &&
         reading.withheld == Withheld::nothing && (!reading.held || reading.held->finite()) &&
         reading.pose.position.allFinite() && q.coeffs().allFinite() && q.squaredNorm() > 0.0;
}

/// The pose is known, but the device gives no force.
bool only_shown(const DeviceReading& reading) {
  if (reading.withheld == Withheld::nothing || reading.withheld == Withheld::not_homed)
    return false;
  DeviceReading shown = reading;
  shown.withheld = Withheld::nothing;
  return good(shown);
}

/// Whether the hand stands still with a force: it would feel a sudden fall or rise.
bool stands_still(const DeviceSpec& spec, const BoundingStep& step, const Command& held) {
  constexpr double kSmall = 10.0 * kFeltForce, kSmallTorque = 10.0 * kFeltTorque;
  if (length(held.force()) < kSmall && length(held.torque) < kSmallTorque) return false;
  constexpr double kSlow = 0.02, kTurnsSlowly = 0.5;  // [m/s], [rad/s]
  const double most = std::max(spec.position_resolution, kSlow * step.hold_time);
  const double most_turn = std::max(spec.rotational_resolution, kTurnsSlowly * step.hold_time);
  return step.displacement.cwiseAbs().maxCoeff() <= (1.0 + 1e-9) * most &&
         step.rotation.cwiseAbs().maxCoeff() <= (1.0 + 1e-9) * most_turn;
}

/// The device has no fault, although its reading was not used.
bool without_fault(const ForceTrail& trail) {
  return trail.clutched || trail.device_ended || trail.withheld != Withheld::nothing;
}

constexpr double kDevicePatience = 0.25;  // of the hold time, for a device without new readings

}  // namespace

void Servo::release() noexcept {
  released_ = true;
  start_letting_go();
}

void Servo::reconnected(bool fresh) noexcept {
  if (fresh) withheld_before_ = statistics_.withheld;
  if (fresh) fresh_ = true;
  if (released_) return;
  if (holds()) {
    found_again_ = true;
    start_letting_go();
  } else {
    begin_anew(sample_.index);
  }
}

void Servo::start_letting_go() noexcept {
  if (letting_go_) return;
  letting_go_ = true;
  let_go_from_ = last_tick_;
}

void Servo::begin_anew(std::uint64_t last_sample_before) noexcept {
  safety_.begin_anew();
  forget_surfaces();
  anew_after_ = last_sample_before;
  newest_original_ = false;  // earlier answers do not tell where the hand is now
}

/// Forgets them until the next reply.
void Servo::forget_surfaces() noexcept {
  local_.clear();
  local_body_.clear();
  if (remote_) remote_->forget();
  last_offset_.setZero();
  if (law_.scene_change_gate) law_.scene_change_gate->forget();
}

bool Servo::waits_for_news(const DeviceReading& reading, Nanoseconds now) noexcept {
  if (reading.fresh || !reading.ok || reading.ended || !position_known_) return false;
  ++statistics_.stale_readings;
  return seconds(now - last_tick_) < kDevicePatience * law_.parameters.hold_time;
}

const Sample* Servo::tick(Device& device, Nanoseconds now) noexcept {
  const DeviceReading reading = device.read(now);
  if (waits_for_news(reading, now)) return nullptr;
  return hold(device.write(render(reading, now)));
}

/// Whether no hand can have moved to the place of a good reading. Ticks are irregular: a tick
/// sooner than a period after the last one may show the movement of a whole period.
bool Servo::jumps(const DeviceReading& reading, double elapsed) noexcept {
  if (reading.jumped) return *reading.jumped;
  if (!position_known_) {
    moves_.forget();
    turns_.forget();
    return false;
  }
  const double time = std::max(elapsed, period_);
  const bool moved = moves_.made(reading.pose.position - sample_.pose.position, time);
  if (spec_.rotation_sensed == 0) return !moved;
  const Quaternion now = reading.pose.orientation.normalized();
  return !turns_.made(rotation_between(sample_.pose.orientation, now), time) || !moved;
}

/// Corrects the held force before the movement under it is accounted.
void Servo::correct(const Command& held) noexcept {
  statistics_.forces_corrected += length(held.force() - held_.force()) > kFeltForce ? 1 : 0;
  account_for(held);
}

void Servo::account_for(const Command& held) noexcept {
  if (held == held_) return;
  held_ = held;
  law_.bounding.set_held(held_);
  safety_.set_held(held_);
  if (law_.account) law_.account->set_held(held_);
}

/// [s]; the period at the first tick, or if the clock was set back.
double Servo::time_since_last_tick(Nanoseconds now) noexcept {
  if (!ticked_) return period_;
  const Nanoseconds elapsed = now - last_tick_;
  if (elapsed.count() < 0) {  // set back: remembered times move with it, and age by a tick
    newest_arrival_ += elapsed - from_seconds(period_);
    newest_sampled_ += elapsed - from_seconds(period_);
    let_go_from_ += elapsed - from_seconds(period_);
    return period_;
  }
  if (seconds(elapsed) > law_.parameters.hold_time) stood_still_after_ = sample_.index;
  return seconds(elapsed);
}

double Servo::fade_factor() const noexcept {
  const double half = 0.5 * law_.parameters.hold_time;
  const double by_age = std::clamp((law_.parameters.hold_time - command_age_) / half, 0.0, 1.0);
  if (!letting_go_) return by_age;
  return std::clamp(1.0 - seconds(last_tick_ - let_go_from_) / half, 0.0, by_age);
}

/// The share of the command for this tick. If the force faded to zero because answers were missing,
/// the hand has moved on and meets a scene that asks for more: it begins as after a lost session. A
/// force that did not fade to zero comes back as slowly as it faded.
double Servo::share_of_command(double elapsed) noexcept {
  const double factor = fade_factor();
  const double half = 0.5 * law_.parameters.hold_time;
  share_ = std::min(factor, share_ + std::max(elapsed, 0.0) / half);
  if (!(factor > 0.0) && !letting_go_) begin_anew(sample_.index);
  return share_;
}

/// Fades from at most the device's force: a far larger command would vanish in a single step.
Command Servo::faded(const Command& command, double factor) const noexcept {
  if (!(factor < 1.0)) return command;
  const double force = length(command.force()), torque = length(command.torque);
  const double most_force = law_.bounding.config().max_force;
  const double most_torque = law_.bounding.config().max_torque;
  const double of_force = force > most_force ? factor * (most_force / force) : factor;
  const double of_torque = torque > most_torque ? factor * (most_torque / torque) : factor;
  return {of_force * command.elastic, of_force * command.frictional, of_torque * command.torque};
}

/// The movement since the last tick. Across a fault it is unknown, so none is credited. The storage
/// of the held force covers the worst of it (bounding.md), and that force has become zero.
Servo::Movement Servo::moved_to(const DeviceReading& reading) noexcept {
  Movement moved;
  moved.known = position_known_;
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

/// Lets in the part of a changed scene that the hand has paid for.
void Servo::admit_change(const BoundingStep& step) noexcept {
  const double energy =
      law_.scene_change_gate->energy({.held = held_,
                                      .displacement = step.displacement,
                                      .hold_time = reserve_.hold_time_of_any_hand(),
                                      .command = step.command,
                                      .margin = port_.margin()},
                                     *law_.account);
  // Elastic storage already has the pressed energy: do not add it twice.
  if (energy > 0.0 && law_.parameters.storage != Storage::elastic) law_.bounding.endow(energy);
}

/// Returns the part of the command that the account has energy for. `moved_known`: the step's
/// movement was measured.
Command Servo::paid_for(const Command& command, BoundingStep step, bool moved_known) noexcept {
  if (!law_.account) return command;
  constexpr double kInstant = 1e-9;  // [s] if the clock stood still
  step.command = command;
  step.hold_time = std::max(step.hold_time, kInstant);
  if (!moved_known) step.displacement.setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::uint64_t strong_hand = law_.account->statistics().strong_hand;
  Command given = law_.account->step(
      step, law_.counts_on_mass ? reserve_.hold_time() : reserve_.hold_time_of_any_hand());
  statistics_.account_cut += given == command ? 0 : 1;
  judge_debt(step.hold_time, strong_hand);
  return given;
}

/// The debt from before this run is no fault of it. Energy burned since then reduces that debt.
void Servo::judge_debt(double hold_time, std::uint64_t strong_hand_before) noexcept {
  const double balance = law_.account->balance();
  forgiven_ = std::clamp(balance, forgiven_, 0.0);
  if (overdraft_) {
    overdraft_->debt = std::max(overdraft_->debt, -balance);
  } else if (balance < forgiven_ - kLargestDebt) {
    overdraft_ = {.debt = -balance,
                  .hold_time = hold_time,
                  .strong_hand = law_.account->statistics().strong_hand > strong_hand_before};
    trail_.overdrawn = true;
  }
}

Command Servo::render(const DeviceReading& reading, Nanoseconds now) noexcept {
  BoundingStep step;
  bool moved_known = false;
  step.hold_time = time_since_last_tick(now);
  ticked_ = true;
  last_tick_ = now;
  elapsed_ = step.hold_time;
  sample_.client_time = now;
  command_age_ = has_reply() ? seconds(now - newest_arrival_) : 0.0;
  if (reading.ended) device_ended_ = released_ = true;

  deadman_ = reading.ok && reading.deadman && !released_ && !overdraft_;
  if (reading.ok) gripper_ = reading.gripper;
  if (remote_) choose_robot(reading);
  const bool jumped = good(reading) && jumps(reading, step.hold_time);
  const bool read = good(reading) && !jumped, usable = read && !device_ended_;
  trail_ = {.observer = options_.observes,
            .device_ended = device_ended_,
            .released = released_,
            .letting_go = letting_go_,
            .law_change = next_law_ != nullptr,
            .overdrawn = overdraft_.has_value(),
            .read = read,
            .jumped = jumped,
            .clutched = reading.ok && reading.clutched,
            .withheld = reading.ok ? reading.withheld : Withheld::nothing,
            .answered = has_reply(),
            .silent = !(command_age_ < law_.parameters.hold_time),
            .recovering = newest_.recovering,
            .server_bound = newest_.active || newest_.saturated || newest_.refused};
  if (read) {
    if (reading.held) correct(*reading.held);
    const Movement moved = moved_to(reading);
    step.displacement = moved.displacement;
    step.rotation = moved.rotation;
    moved_known = moved.known;
    if (!actuation_lag_.certain() && moved.known && !reading.held)
      account_for(actuation_lag_.worst(moved.displacement, moved.rotation));
    displacement_ = moved.displacement;
    port_.step(held_, moved.displacement, moved.rotation, step.hold_time);
    if (remote_) {
      const double energy =
          remote_->step(sample_.pose.position, moved.displacement, held_.force(), step.hold_time);
      if (law_.account) law_.account->credit(energy);
    }
  } else {
    if (!without_fault(trail_)) ++statistics_.device_faults;
    statistics_.jumps += jumped ? 1 : 0;
    if (only_shown(reading)) moved_to(reading);
    position_known_ = false;
    measures_.lose();
    begin_anew(sample_.index + (posed_ ? 1 : 0));  // this tick's sample has the old position
  }
  reserve_.saw(step.hold_time, moved_known && stands_still(spec_, step, held_));

  wanted_ = {};
  double factor = 0.0;  // of the command
  bool original = newest_original_;
  if (usable && has_reply() && !overdraft_) {
    const Command asked = environment(step, now);
    // Only what the device can give goes into the bound, so that the bound accounts what it gives.
    wanted_ = actuated(spec_, asked);
    factor = share_of_command(step.hold_time);
    // A command that has faded to zero does not tell where the hand is now.
    original = factor > 0.0 && (newest_original_ || near_);
    if (factor < 1.0) ++statistics_.faded;
    step.command = faded(wanted_, factor);
    trail_.asked = asked;
    trail_.actuated = wanted_;
    trail_.faded = step.command;
    if (near_ && law_.shapes) step.command = rise_limited(step);
  } else {
    near_ = false;
  }

  if (law_.scene_change_gate) admit_change(step);
  Bounded bounded = law_.bounding.step(step);
  if (law_.scene_change_gate)
    law_.scene_change_gate->given(bounded.rendered.elastic, step.command.elastic);
  // The paper's laws would keep a part of the last force; zero is passive too.
  if (!(factor > 0.0)) bounded.rendered = {};
  statistics_.bound_active += bounded.active ? 1 : 0;
  statistics_.saturated += bounded.saturated ? 1 : 0;
  statistics_.refused += bounded.refused ? 1 : 0;

  trail_.bounded = bounded.rendered;
  trail_.in_debt = bounded.in_debt;
  trail_.refused = bounded.refused;
  const Command safe = safeguard(bounded.rendered, step, original);
  Command given = paid_for(safe, step, moved_known);
  trail_.paid = given;
  if (letting_go_ && !released_ && !(factor > 0.0)) {
    letting_go_ = false;
    newest_.command = {};
    newest_.predicted = false;
    if (found_again_) begin_anew(sample_.index);
    found_again_ = false;
    given = {};  // a fade ends with zero, whatever the bound keeps
    if (next_law_ != nullptr) exchange_law();
  }
  if (overdraft_) given = {};
  return given_ = given;
}

const Sample* Servo::hold(const Command& held) noexcept {
  if (!held.finite()) ++statistics_.device_faults;
  held_ = actuation_lag_.written(given_, held.finite() ? held : Command{});
  law_.bounding.set_held(held_);
  safety_.set_held(held_);
  if (law_.account) law_.account->set_held(held_);
  if (!near_) rise_.given(held_);
  statistics_.max_force = std::max(statistics_.max_force, length(held_.force()));
  if (feels_scene()) observe_direction(held_);
  follow_trouble(held_);
  explain(held_);
  if (!posed_) return nullptr;

  sample_.held = held_;
  ++sample_.index;
  ++statistics_.samples;
  sent_[sample_.index % sent_.size()] = {sample_.index, sample_.client_time, 0, false};
  return &sample_;
}

std::optional<Lead> Servo::lead() const noexcept {
  if (!remote_) return std::nullopt;
  return remote_->lead(deadman_, gripper_);
}

HandReport Servo::report() const noexcept {
  // A shaped force is never exactly the requested one: report only what is felt.
  constexpr double kMuchLess = 0.95;
  const auto takes_off = [](const Command& before, const Command& after) {
    const double was = length(before.force());
    return was > kFeltForce && length(after.force()) < kMuchLess * was;
  };
  HandReport report;
  const auto put = [&](HandReason reason, bool holds) {
    if (holds) report.reasons |= bit(reason);
  };
  const bool felt = length(trail_.asked.force()) > kFeltForce;
  const bool bounds = takes_off(trail_.faded, trail_.bounded);
  const bool limits = takes_off(trail_.bounded, trail_.safe);
  put(HandReason::near, felt && near_);
  put(HandReason::late, felt && !near_);
  put(HandReason::saturated, takes_off(trail_.asked, trail_.actuated));
  put(HandReason::faded, takes_off(trail_.actuated, trail_.faded) && !letting_go_);
  put(HandReason::bound, bounds);
  put(HandReason::shaping, bounds && law_.shapes);
  put(HandReason::limits, limits);
  put(HandReason::ramp, limits && trail_.ramped);
  put(HandReason::slew, limits && trail_.slewed);
  put(HandReason::velocity_limit, limits && trail_.too_fast);
  put(HandReason::wait_for_small_force, limits && trail_.stage_waits);
  put(HandReason::account, takes_off(trail_.safe, trail_.paid));
  put(HandReason::debt, (bounds && trail_.in_debt) || overdraft_ || is_debt(-owed()));
  put(HandReason::ending, released_);
  put(HandReason::reconnecting, letting_go_ && !released_ && next_law_ == nullptr);
  put(HandReason::law_change, next_law_ != nullptr);
  put(HandReason::scene_change, withholds_change());
  put(HandReason::device_fault, (!trail_.read && !without_fault(trail_)) ||
                                    (spec_.late_ticks == 0 && takes_off(trail_.paid, trail_.held)));
  put(HandReason::clutched, trail_.clutched);
  put(HandReason::emergency, trail_.withheld == Withheld::emergency);
  put(HandReason::not_ready,
      trail_.withheld != Withheld::nothing && trail_.withheld != Withheld::emergency);
  report.has_account = law_.account.has_value();
  report.balance = law_.account ? law_.account->balance() : 0.0;
  report.round_trip = has_reply() ? seconds(newest_arrival_ - newest_sampled_) : 0.0;
  report.hand_damping = hand_credit() ? hand_credit()->damping : 0.0;
  return report;
}

/// The account scales force and torque alike, so either one shows the cut.
double Servo::account_cut() const noexcept {
  const double force = length(trail_.safe.force()), torque = length(trail_.safe.torque);
  if (force > 0.0) return std::clamp(1.0 - length(trail_.paid.force()) / force, 0.0, 1.0);
  return torque > 0.0 ? std::clamp(1.0 - length(trail_.paid.torque) / torque, 0.0, 1.0) : 0.0;
}

void Servo::explain(const Command& held) noexcept {
  trail_.held = held;
  no_force_ = zero_force_reason(trail_);
  ++statistics_.no_force[static_cast<std::size_t>(no_force_)];
  if (!position_known_) return;
  if (feels_scene())
    measures_.take(displacement_, wanted_.elastic, held.force());
  else
    measures_.lose();
}

/// Whether this tick shows how the scene feels: only the bound, the account and the limits of the
/// device stand between its command and the hand.
bool Servo::feels_scene() const noexcept {
  return position_known_ && !released_ && !letting_go_ && share_ >= 1.0 && !trail_.stage_waits &&
         !trail_.ramped && !trail_.recovering && !withholds_change();
}

void Servo::follow_trouble(const Command& held) noexcept {
  if (trail_.read) no_position_for_ = 0.0;
  if (!trail_.read && !without_fault(trail_)) no_position_for_ += elapsed_;
  if (released_) return;
  if (length(held.force()) >= kFeltForce || length(held.torque) >= kFeltTorque)
    not_held_for_ = 0.0;
  else if (length(trail_.paid.force()) >= kFeltForce || length(trail_.paid.torque) >= kFeltTorque)
    not_held_for_ += elapsed_;
}

std::optional<Servo::DeviceTrouble> Servo::device_trouble() const noexcept {
  const double patience = kDevicePatience * law_.parameters.hold_time;
  if (!device_ended_ && no_position_for_ >= patience)
    return DeviceTrouble{ZeroForceReason::device_fault, no_position_for_};
  if (not_held_for_ >= patience) return DeviceTrouble{ZeroForceReason::not_held, not_held_for_};
  return std::nullopt;
}

void Servo::observe_direction(const Command& held) noexcept {
  const Vec3 given = held.force();
  const Vec3 wanted = wanted_.force();
  if (!(length(given) > kSmallestForce) || !(length(wanted) > kSmallestForce)) return;
  const Vec3 u = direction(given), v = direction(wanted);
  // Accurate for every angle; the arc cosine loses half the digits near zero.
  const double angle = 2.0 * std::atan2((u - v).norm(), (u + v).norm());
  constexpr double kMicrodegrees = 1e6 * 180.0 / std::numbers::pi;
  statistics_.direction_error.record(std::llround(kMicrodegrees * angle));
}

}  // namespace feltwire

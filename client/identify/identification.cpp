#include "client/identify/identification.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>
#include <sstream>
#include <stdexcept>

#include "core/base/clamp_length.hpp"

namespace feltwire {
namespace {

// The controller is a soft spring and damper towards the target position, similar to a light hand.
constexpr double kStiffness = 200.0, kDamping = 2.0;  // [N/m], [N s/m]
constexpr double kBrake = 5.0;  // [N s/m] extra damping above kExcess times the planned speed
constexpr double kExcess = 1.5;
constexpr double kFilter = 3e-3;  // [s] time constant of the velocity filter
constexpr double kSlew = 100.0;   // [N/s] fastest change of the force
// [s] Durations of the phases.
constexpr double kSettle = 1.0, kRest = 1.0, kApproach = 0.6, kFade = 0.2;
constexpr double kBeyond = 0.03;   // [s] time after the last cycle for the averaging windows
constexpr double kRoom = 1.5;      // ratio of reserved ticks to expected ticks
constexpr double kSharpest = 5.0;  // [m/s^2] largest acceleration at a turn
// A coast ends after kLongestCoast, at the position kCoastUntil, or at a speed below kCoasted or
// above kFallen times the push speed. An unbalanced handle may become faster.
constexpr double kLongestCoast = 0.4, kCoastUntil = 0.4;  // [s], [amplitudes]
constexpr double kCoasted = 0.15, kFallen = 1.3;
constexpr double kLeastBrake = 1.0;  // [m/s^2] smallest deceleration after a coast
// Vibration force: first and largest amplitude relative to the largest force, smallest and largest
// vibration speed relative to the sweep speed, and time constants [s] for the growth and decay of
// the amplitude and for the decay of the measured vibration speed.
constexpr double kFirstShake = 0.02, kMostShake = 0.5;
constexpr double kLeastSwing = 0.5, kMostSwing = 0.7;
constexpr double kShakeGrows = 0.12, kShakeShrinks = 0.03, kSwingFades = 0.1;
constexpr double kUsualAmplitude = 0.02, kLargestAmplitude = 0.025, kTopSpeed = 0.25;

double sweep_time(const Sweep& sweep, double amplitude) {
  return (sweep.cycles + 1) * cycle_time(sweep, amplitude);
}

}  // namespace

IdentifyLimits identify_limits(const DeviceSpec& spec, std::optional<double> force) {
  constexpr double kTravelOverAmplitude = 1.6, kOfWorkspace = 0.16, kOfForce = 0.15;
  constexpr double kLeastOfForce = 0.01;  // a smaller force moves no handle against its friction
  const double room = spec.workspace.head(spec.translation_dof).minCoeff();
  IdentifyLimits limits;
  limits.amplitude =
      room > 0.0 ? std::min(kOfWorkspace * room, kLargestAmplitude) : kUsualAmplitude;
  limits.travel = kTravelOverAmplitude * limits.amplitude;
  // The handle brakes in a fifth of the time of a stroke (half a cycle). At the sweep speed v, its
  // deceleration is then 2 v^2 / amplitude.
  limits.top_speed = std::min(kTopSpeed, std::sqrt(0.5 * kSharpest * limits.amplitude));
  limits.speed = 2.0 * limits.top_speed;
  limits.force = force.value_or(kOfForce * spec.max_force);
  const double least = kLeastOfForce * spec.max_force;
  if (!(limits.force >= least && limits.force <= spec.continuous_force)) {
    std::ostringstream text;
    text << "--force " << limits.force << ": use at least " << least
         << " N (a smaller force does not move the handle) and at most " << spec.continuous_force
         << " N (the device can hold no larger one for long)";
    throw std::invalid_argument(text.str());
  }
  return limits;
}

Identification::Identification(const DeviceSpec& spec, const IdentifyLimits& limits, double period)
    : limits_(limits), dof_(spec.translation_dof) {
  const auto room = [period](double time) {
    return static_cast<std::size_t>(kRoom * time / period) + 100;
  };
  recordings_.rest.reserve(room(kRest));
  duration_ = kSettle + kRest + kFade;
  std::vector<Sweep> plan = sweep_plan(dof_, limits.top_speed);
  for (const Sweep& sweep : shaken_plan(dof_, limits.top_speed)) plan.push_back(sweep);
  for (const Sweep& sweep : resonance_plan(dof_, limits.top_speed)) plan.push_back(sweep);
  for (const Sweep& sweep : plan) {
    SweepRecord run{sweep, {}, {}};
    const double time = sweep_time(sweep, limits.amplitude) + kBeyond;
    run.ticks.reserve(room(time));
    run.turns.reserve(static_cast<std::size_t>(sweep.cycles) + 1);
    duration_ += kApproach + time;
    recordings_.sweeps.push_back(std::move(run));
  }
  for (const CoastDown& coast : coast_down_plan(dof_, limits.top_speed)) {
    CoastDownRecord run{coast, {}};
    run.ticks.reserve(room(kLongestCoast));
    duration_ += kApproach + 2.0 * limits.amplitude / coast.speed;
    recordings_.coasts.push_back(std::move(run));
  }
}

void Identification::give_up(const char* why) noexcept {
  if (state_ != State::measuring) return;
  state_ = State::gave_up;
  why_ = why;
}

double Identification::progress() const {
  return state_ == State::done ? 1.0 : std::min(0.999, (handle_.time - first_) / duration_);
}

int Identification::line() const {
  const bool swept = phase_ == Phase::approach || phase_ == Phase::sweep;
  if (!swept || !sweeps() || state_ != State::measuring) return -1;
  int line = 0;
  for (std::size_t n = 1; n <= run_; ++n)
    if (recordings_.sweeps[n].sweep.along != recordings_.sweeps[n - 1].sweep.along) ++line;
  return line;
}

Vec3 Identification::step(double time, const Vec3& position) noexcept {
  recordings_.open = nullptr;
  if (!handle_.known) {
    handle_.known = true;
    first_ = phase_began_ = handle_.time = time;
    handle_.start = handle_.position = position;
  }
  if (state_ == State::measuring && odd(time, position)) handle_.velocity.setZero();
  if (state_ != State::measuring) return Vec3::Zero();
  Vec3 force = pull(time, position);
  handle_.time = time;
  handle_.position = position;
  if (state_ != State::measuring) return Vec3::Zero();
  record(time, position);
  return force;
}

void Identification::held(const Vec3& force) noexcept {
  if (!force.allFinite()) return give_up("the device says that it holds a force that is no number");
  force_ = force;
  largest_ = std::max(largest_, force.norm());
  if (recordings_.open != nullptr) recordings_.open->back().force = force;
}

/// Gives up the measurement and returns true if a free handle cannot cause this reading.
bool Identification::odd(double time, const Vec3& position) noexcept {
  if (!position.allFinite()) return give_up("the device gave a position that is no number"), true;
  const double span = time - handle_.time;
  if (span < 0.0 || span > limits_.late)
    return give_up("the readings came too late; is the machine busy?"), true;
  if (span > 0.0) {
    const double share = span / (span + kFilter);
    handle_.velocity += share * ((position - handle_.position) / span - handle_.velocity);
  }
  if ((position - handle_.start).norm() > limits_.travel)
    return give_up("the handle left the room that it may move in; is it held, or not balanced?"),
           true;
  if (handle_.velocity.norm() > limits_.speed)
    return give_up("the handle moved too fast; is it held, or not balanced?"), true;
  return false;
}

/// Moves the target position `led_` as the phase requires. Returns the force towards it.
Vec3 Identification::pull(double time, const Vec3& position) noexcept {
  const double in_phase = time - phase_began_;
  double strength = 1.0, meant = limits_.top_speed;  // [m/s] `meant` is the planned speed
  Vec3 shake = Vec3::Zero();
  const double amplitude = limits_.amplitude;
  switch (phase_) {
    case Phase::rest:
      if (in_phase > kSettle + kRest) begin(Phase::approach, time);
      break;
    case Phase::approach: {
      const double done = std::min(in_phase / kApproach, 1.0);
      const double soft = 0.5 - 0.5 * std::cos(std::numbers::pi * done);
      led_ = led_from_ - soft * (led_from_ + amplitude * line_along());
      if (done >= 1.0) begin(sweeps() ? Phase::sweep : Phase::push, time);
      break;
    }
    case Phase::sweep: {
      const Sweep& sweep = recordings_.sweeps[run_].sweep;
      meant = sweep.speed;
      led_ = led_to(sweep, amplitude, in_phase) * sweep.along;
      if (sweep.shake > 0.0) {
        meant *= 1.0 + kMostSwing;
        shake = shaken(sweep, in_phase, time - handle_.time) * sweep.along;
      }
      look_for_turn(in_phase);
      if (in_phase >= sweep_time(sweep, amplitude) + kBeyond) next(time);
      break;
    }
    case Phase::push: {
      const CoastDown& coast = recordings_.coasts[coast_].coast;
      meant = coast.speed;
      const double at = led_to({coast.along, coast.speed, 1}, amplitude, in_phase);
      led_ = at * coast.along;
      if (at >= coast.from * amplitude) begin(Phase::coast, time);
      break;
    }
    case Phase::coast: {
      const CoastDown& coast = recordings_.coasts[coast_].coast;
      const double at = coast.along.dot(position - handle_.start);
      coasted_ = coast.along.dot(handle_.velocity);
      led_ = at * coast.along;
      if (at > kCoastUntil * amplitude || coasted_ < kCoasted * coast.speed ||
          coasted_ > kFallen * coast.speed || in_phase > kLongestCoast)
        begin(Phase::brake, time);
      break;
    }
    case Phase::brake: {  // decelerates from the present speed to rest, as at the turn of a sweep
      const CoastDown& coast = recordings_.coasts[coast_].coast;
      meant = coast.speed;
      const double speed = std::max(coasted_, 0.0);
      const double room = std::max(amplitude - coast.along.dot(led_from_), 0.1 * amplitude);
      const double brake = std::max(kLeastBrake, 0.5 * speed * speed / room);
      const double braking = std::min(in_phase, speed / brake);
      led_ = led_from_ + (speed - 0.5 * brake * braking) * braking * coast.along;
      if (in_phase * brake >= speed) next(time);
      break;
    }
    case Phase::fade:
      strength = std::max(0.0, 1.0 - in_phase / kFade);
      if (in_phase >= kFade) state_ = State::done;
      break;
  }
  Vec3 wanted = kStiffness * (handle_.start + led_ - position) - kDamping * handle_.velocity;
  const double speed = handle_.velocity.norm(), excess = speed - kExcess * meant;
  // Extra damping limits the overshoot of a heavy handle.
  if (excess > 0.0) wanted -= kBrake * excess / speed * handle_.velocity;
  if (phase_ == Phase::coast) wanted -= line_along().dot(wanted) * line_along();
  if (dof_ == 2) wanted.z() = 0.0;
  wanted = strength * clamp_length(wanted, limits_.force);
  const Vec3 led = force_ - shake_.force;
  shake_.force = shake;
  return clamp_length(led + clamp_length(wanted - led, kSlew * (time - handle_.time)) + shake,
                      limits_.force);
}

/// Returns the vibration force along a sweep [N]. Its amplitude grows in the cycle before the
/// measured cycles, until the vibration speed is half the sweep speed. The vibration then never
/// reverses the movement, so the dry friction keeps its direction.
double Identification::shaken(const Sweep& sweep, double in_phase, double span) noexcept {
  const double cycle = cycle_time(sweep, limits_.amplitude);
  if (in_phase < span + 1e-9 || shake_.level == 0.0) {
    const double before = run_ > 0 ? recordings_.sweeps[run_ - 1].sweep.shake : 0.0;
    shake_.level = before > 0.0 && before < sweep.shake ? kLeastSwing * shake_.level
                                                        : kFirstShake * limits_.force;
    shake_.swing = 0.0;
  }
  const double of_way = std::fmod(in_phase, 0.5 * cycle) / (0.5 * cycle);
  if (in_phase < cycle && of_way > 1.5 * kTurnShare && of_way < 1.0 - kTurnShare) {
    const double led = in_phase < 0.5 * cycle ? sweep.speed : -sweep.speed;
    shake_.swing = std::max(shake_.swing * std::exp(-span / kSwingFades),
                            std::abs(sweep.along.dot(handle_.velocity) - led));
    if (shake_.swing < kLeastSwing * sweep.speed) shake_.level *= std::exp(span / kShakeGrows);
    if (shake_.swing > kMostSwing * sweep.speed) shake_.level *= std::exp(-span / kShakeShrinks);
    shake_.level = std::min(shake_.level, kMostShake * limits_.force);
  }
  return shake_.level * shake_share(sweep, limits_.amplitude, in_phase);
}

void Identification::begin(Phase phase, double time) noexcept {
  phase_ = phase;
  phase_began_ = time;
  led_from_ = led_;
}

const Vec3& Identification::line_along() const noexcept {
  return sweeps() ? recordings_.sweeps[run_].sweep.along : recordings_.coasts[coast_].coast.along;
}

/// Starts the next sweep or coast, or ends the measurement.
void Identification::next(double time) noexcept {
  const bool last = !sweeps() && coast_ + 1 == recordings_.coasts.size();
  if (sweeps())
    ++run_;
  else if (!last)
    ++coast_;
  begin(last ? Phase::fade : Phase::approach, time);
}

/// Adds the next recorded tick to `turns` if it starts a cycle or ends the last cycle.
void Identification::look_for_turn(double in_phase) noexcept {
  SweepRecord& run = recordings_.sweeps[run_];
  const double next = static_cast<double>(run.turns.size()) + 1.0;
  if (run.turns.size() <= static_cast<std::size_t>(run.sweep.cycles) &&
      in_phase >= next * cycle_time(run.sweep, limits_.amplitude))
    run.turns.push_back(run.ticks.size());
}

void Identification::record(double time, const Vec3& position) noexcept {
  const bool rests = phase_ == Phase::rest && time - phase_began_ > kSettle;
  const bool coasts = phase_ == Phase::coast;
  if (!rests && !coasts && phase_ != Phase::sweep) return;
  std::vector<SweepTick>& ticks = rests    ? recordings_.rest
                                  : coasts ? recordings_.coasts[coast_].ticks
                                           : recordings_.sweeps[run_].ticks;
  if (ticks.size() == ticks.capacity())
    return give_up("the readings come more often than the device says");
  ticks.push_back({time, position, Vec3::Zero()});
  recordings_.open = &ticks;
}

}  // namespace feltwire

#include "client/servo/explanation.hpp"

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

constexpr double kSmallestForce = 1e-6;  // [N] the direction of a smaller force is noise

/// Returns whether the device has no fault, although the servo did not use its reading.
bool without_fault(const ForceTrail& trail) {
  return trail.device.clutched || trail.device.ended || trail.device.withheld != Withheld::nothing;
}

/// Returns whether the hand can feel the reduction from `before` to `after`. A small reduction does
/// not count, because shaping always changes the force a little.
bool takes_off(const Command& before, const Command& after) {
  constexpr double kMuchLess = 0.95;
  const double was = length(before.force());
  return was > kFeltForce && length(after.force()) < kMuchLess * was;
}

void observe_direction(const Vec3& wanted, const Vec3& given, ServoStatistics& statistics) {
  if (!(length(given) > kSmallestForce) || !(length(wanted) > kSmallestForce)) return;
  const Vec3 u = direction(given), v = direction(wanted);
  // This half-angle formula is accurate for every angle. The arc cosine loses half the digits near
  // zero.
  const double angle = 2.0 * std::atan2((u - v).norm(), (u + v).norm());
  constexpr double kMicrodegrees = 1e6 * 180.0 / std::numbers::pi;
  statistics.direction_error.record(std::llround(kMicrodegrees * angle));
}

}  // namespace

void Explanation::take(const Tick& tick, ServoStatistics& statistics) noexcept {
  statistics.max_force = std::max(statistics.max_force, length(tick.held.force()));
  if (tick.feels_scene) observe_direction(tick.wanted.force(), tick.held.force(), statistics);
  if (!tick.released) {
    if (is_felt(tick.held))
      not_held_for_ = 0.0;
    else if (is_felt(trail_.command.paid))
      not_held_for_ += tick.elapsed;
  }
  trail_.command.held = tick.held;
  reason_ = zero_force_reason(trail_);
  ++statistics.no_force[static_cast<std::size_t>(reason_)];
  if (!tick.known) return;
  if (tick.feels_scene)
    measures_.take(tick.displacement, tick.wanted.elastic, tick.held.force());
  else
    measures_.lose();
}

/// Returns the share of the command that the energy account removes. The account scales force and
/// torque by the same factor, so either shows this share.
double Explanation::account_cut() const noexcept {
  const Command &safe = trail_.command.safe, &paid = trail_.command.paid;
  const double force = length(safe.force()), torque = length(safe.torque);
  if (force > 0.0) return std::clamp(1.0 - length(paid.force()) / force, 0.0, 1.0);
  return torque > 0.0 ? std::clamp(1.0 - length(paid.torque) / torque, 0.0, 1.0) : 0.0;
}

std::uint32_t Explanation::reasons(const State& state) const noexcept {
  std::uint32_t reasons = 0;
  const auto put = [&](HandReason reason, bool holds) {
    if (holds) reasons |= bit(reason);
  };
  const CommandTrail& command = trail_.command;
  const bool asked = length(command.asked.force()) > kFeltForce;
  const bool bounds = takes_off(command.faded, command.bounded);
  const bool limits = takes_off(command.bounded, command.safe);
  put(HandReason::near, asked && state.near);
  put(HandReason::late, asked && !state.near);
  put(HandReason::saturated, takes_off(command.asked, command.actuated));
  put(HandReason::faded, takes_off(command.actuated, command.faded) && !state.fades);
  put(HandReason::bound, bounds);
  put(HandReason::shaping, bounds && state.shapes);
  put(HandReason::limits, limits);
  put(HandReason::ramp, limits && trail_.safety.ramped);
  put(HandReason::slew, limits && trail_.safety.slewed);
  put(HandReason::velocity_limit, limits && trail_.safety.too_fast);
  put(HandReason::wait_for_small_force, limits && trail_.safety.waits);
  put(HandReason::account, takes_off(command.safe, command.paid));
  put(HandReason::debt, (bounds && trail_.in_debt) || state.in_debt);
  put(HandReason::ending, state.released);
  put(HandReason::reconnecting, state.fades && !state.released && !state.law_changes);
  put(HandReason::law_change, state.law_changes);
  put(HandReason::scene_change, state.withholds_change);
  put(HandReason::device_fault, (!trail_.device.usable && !without_fault(trail_)) ||
                                    (state.on_time && takes_off(command.paid, command.held)));
  put(HandReason::clutched, trail_.device.clutched);
  put(HandReason::emergency, trail_.device.withheld == Withheld::emergency);
  put(HandReason::not_ready,
      trail_.device.withheld != Withheld::nothing && trail_.device.withheld != Withheld::emergency);
  return reasons;
}

}  // namespace feltwire

#include "client/servo/force_law.hpp"

#include <limits>
#include <utility>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

bool pulls(const Command& c) { return !c.force().isZero(0.0) || !c.torque.isZero(0.0); }

/// Returns whether the hand rests while it feels a force. Such a hand would feel a sudden change of
/// the force.
bool stands_still(const DeviceSpec& spec, const BoundingStep& step, const Command& held) {
  constexpr double kSmall = 10.0 * kFeltForce, kSmallTorque = 10.0 * kFeltTorque;
  if (length(held.force()) < kSmall && length(held.torque) < kSmallTorque) return false;
  constexpr double kSlow = 0.02, kTurnsSlowly = 0.5;  // [m/s], [rad/s] largest speeds at rest
  const double most = std::max(spec.position_resolution, kSlow * step.hold_time);
  const double most_turn = std::max(spec.rotation.resolution, kTurnsSlowly * step.hold_time);
  return step.displacement.cwiseAbs().maxCoeff() <= (1.0 + 1e-9) * most &&
         step.rotation.cwiseAbs().maxCoeff() <= (1.0 + 1e-9) * most_turn;
}

}  // namespace

ForceLaw::ForceLaw(const DeviceSpec& spec, const SessionParameters& parameters,
                   const ServoOptions& options)
    : spec_(spec),
      law_(spec, parameters, options),
      safety_(options.safety, admits_reduction(parameters)),
      port_(observer_of(spec, parameters)),
      margin_(parameters.servo_period),
      owed_(std::max(0.0, options.owed)),
      debt_(owed_),
      command_delay_(spec.actuation.late_ticks) {
  if (law_.account) law_.account->begin_in_debt(owed_);
}

bool ForceLaw::holds() const noexcept { return pulls(held_) || !command_delay_.nothing_left(); }

void ForceLaw::moved(const DeviceReading& reading, const DeviceMovement& movement, double hold_time,
                     DeviceCounts& counts) noexcept {
  if (reading.held) {
    const bool felt = length(reading.held->force() - held_.force()) > kFeltForce;
    counts.forces_corrected += felt ? 1 : 0;
    account_for(*reading.held);
  } else if (!command_delay_.certain() && movement.known) {
    account_for(command_delay_.worst(movement.displacement, movement.rotation));
  }
  port_.step(held_, movement.displacement, movement.rotation, hold_time);
}

void ForceLaw::account_for(const Command& held) noexcept {
  if (held == held_) return;
  held_ = held;
  set_held();
}

void ForceLaw::set_held() noexcept {
  law_.bounding.set_held(held_);
  safety_.set_held(held_);
  if (law_.account) law_.account->set_held(held_);
}

void ForceLaw::saw(const BoundingStep& step, bool movement_known) noexcept {
  margin_.saw(step.hold_time, movement_known && stands_still(spec_, step, held_));
}

Command ForceLaw::apply(const BoundingStep& step, const Asked& asked, ForceTrail& trail,
                        ForceLawCounts& counts) noexcept {
  if (law_.scene_change_gate) admit_change(step);
  Bounded bounded = law_.bounding.step(step);
  if (law_.scene_change_gate)
    law_.scene_change_gate->given(bounded.rendered.elastic, step.command.elastic);
  // Some bounding methods would keep a part of the last force after a complete fade. Zero force is
  // passive too.
  if (!(asked.share > 0.0)) bounded.rendered = {};
  counts.bound_active += bounded.active ? 1 : 0;
  counts.saturated += bounded.saturated ? 1 : 0;
  counts.refused += bounded.refused ? 1 : 0;
  trail.command.bounded = bounded.rendered;
  trail.in_debt = bounded.in_debt;
  trail.refused = bounded.refused;
  const Command safe = safeguard(bounded.rendered, step, asked, trail, counts);
  trail.command.paid = paid_for(safe, step, asked.movement_known, trail, counts);
  return trail.command.paid;
}

/// Credits the force bound with the energy that the hand has spent against the changed scene.
void ForceLaw::admit_change(const BoundingStep& step) noexcept {
  const double energy =
      law_.scene_change_gate->energy({.held = held_,
                                      .displacement = step.displacement,
                                      .hold_time = margin_.hold_time_of_any_hand(),
                                      .command = step.command,
                                      .margin = port_.margin()},
                                     *law_.account);
  // Storage::elastic already contains this energy.
  if (energy > 0.0 && law_.parameters.storage != Storage::elastic) law_.bounding.endow(energy);
}

Command ForceLaw::safeguard(const Command& bounded, const BoundingStep& step, const Asked& asked,
                            ForceTrail& trail, ForceLawCounts& counts) noexcept {
  const Safeguarded safe = safety_.apply({.commanded = asked.wanted,
                                          .original = trail.device.usable && asked.original,
                                          .bounded = actuated(spec_, bounded),
                                          .displacement = step.displacement,
                                          .rotation = step.rotation,
                                          .hold_time = step.hold_time});
  trail.safety.waits = safety_.waiting();
  trail.refused |= safe.refused;
  trail.safety.too_fast = safe.too_fast;
  trail.safety.ramped = safe.ramped;
  trail.safety.slewed = safe.slewed;
  trail.command.safe = safe.rendered;
  counts.waiting += safe.waiting ? 1 : 0;
  counts.ramped += safe.ramped ? 1 : 0;
  counts.slewed += safe.slewed ? 1 : 0;
  counts.too_fast += safe.too_fast ? 1 : 0;
  counts.force_limited += safe.limited ? 1 : 0;
  return safe.rendered;
}

/// Returns the part of the command for which the energy account has enough energy.
Command ForceLaw::paid_for(const Command& command, BoundingStep step, bool movement_known,
                           ForceTrail& trail, ForceLawCounts& counts) noexcept {
  if (!law_.account) return command;
  PortAccount& account = *law_.account;
  constexpr double kInstant = 1e-9;  // [s] replaces a hold time of zero
  step.command = command;
  step.hold_time = std::max(step.hold_time, kInstant);
  if (!movement_known) step.displacement.setConstant(std::numeric_limits<double>::quiet_NaN());
  const std::uint64_t strong_hand = account.statistics().strong_hand;
  Command given = account.step(
      step, law_.counts_on_mass ? margin_.hold_time() : margin_.hold_time_of_any_hand());
  counts.account_cut += given == command ? 0 : 1;
  debt_.judge(account.balance(), step.hold_time, account.statistics().strong_hand > strong_hand);
  trail.overdrawn = overdraft().has_value();
  return given;
}

void ForceLaw::hold(const Command& given, const Command& told) noexcept {
  held_ = command_delay_.written(given, told.finite() ? told : Command{});
  set_held();
}

void ForceLaw::scene_changed() noexcept {
  if (law_.scene_change_gate) law_.scene_change_gate->begin();
  law_.bounding.scene_changed();
  scene_was_changed_ = true;
}

void ForceLaw::exchange() noexcept {
  owed_ = owed();
  std::swap(law_, *next_);
  const std::optional<PortAccount>& before = next_->account;
  if (law_.account && before)
    law_.account->go_on_from(*before);
  else if (law_.account)
    law_.account->begin_in_debt(owed_);
  // The energy observer port_ must count at least the dry friction that the energy account counts.
  if (law_.counts_on_mass) port_.count_friction(spec_.least_friction);
  next_ = nullptr;
  // The new law was made with the scene data of the join, so tell it that the scene has changed
  // since.
  if (scene_was_changed_) law_.bounding.scene_changed();
  forget_contact();
  // The new energy account may allow the whole force at once, and a sudden force would throw the
  // hand out of the object. So restart the safety limits.
  begin_anew();
}

}  // namespace feltwire

#include "client/servo/servo_law.hpp"

#include "core/bounding/device_account.hpp"

namespace feltwire {
namespace {

BoundingConfig bound_of(const SessionParameters& parameters, const DeviceSpec& spec,
                        double scene_stiffness) {
  validate(spec);
  validate(parameters);
  BoundingConfig config = bounding_config(parameters, spec);
  if (scene_stiffness > 0.0) config.stiffness = scene_stiffness;
  // The server limits the force. The client applies only the safety limits that all modes share.
  if (parameters.side == BoundingSide::server) config.mode = kUnbounded;
  return config;
}

/// Returns whether the energy account uses the device's mass, its dry friction and the hand's
/// largest force. This applies to shaping methods and to a known operator damping.
bool counts_on_mass(const SessionParameters& p) {
  return p.side != BoundingSide::server && needs_account(p) != nullptr;
}

/// Returns the energy account of a session. Shaping methods and methods with operator damping need
/// it for passivity. A force bound at the server needs it, because the server ignores delay, loss
/// and late ticks. A force bound at the client needs it, because the bound assumes that each force
/// is held for one period, and because some bounding methods are not passive. Without a force bound
/// or for a device of unknown damping, there is no account.
std::optional<PortAccount> account_of(const SessionParameters& p, const DeviceSpec& spec,
                                      const ServoOptions& options) {
  if (counts_on_mass(p)) {
    AccountConfig config = account_config(spec, p.servo_period);
    config.learns_outside_force = options.learns_hand_force;
    return PortAccount(config);
  }
  if (p.mode == kUnbounded || !options.account || !(spec.damping.least() > 0.0))
    return std::nullopt;
  return PortAccount(any_hand_account(spec, p.servo_period));
}

/// Returns the gate that withholds the force of a changed scene until the hand has spent the energy
/// for it.
std::optional<SceneChangeGate> scene_change_gate_of(const SessionParameters& p,
                                                    const DeviceSpec& spec,
                                                    const Bounding& bounding,
                                                    const std::optional<PortAccount>& account) {
  if (!bounding.takes_endowment() || !account || p.operator_damping > 0.0) return std::nullopt;
  return SceneChangeGate(largest_slew(spec.max_force, p));
}

}  // namespace

bool admits_reduction(const SessionParameters& parameters) {
  return bounding_method(parameters.mode).admits_reduction;
}

const char* needs_account(const SessionParameters& p) {
  if (p.mode == kUnbounded) return nullptr;
  if (p.side == BoundingSide::server) return " of a bound at the server";
  if (p.operator_damping > 0.0) return " with an operator's damping";
  return bounding_method(p.mode).shapes ? "" : nullptr;
}

/// Returns the observer of the energy at the device. It counts the damping of the device without
/// the hand, and the dry friction if the energy account counts it.
PortEnergy observer_of(const DeviceSpec& spec, const SessionParameters& p) {
  return {spec.damping,
          spec.rotation_actuated > 0 ? spec.rotational_damping : Damping(),
          p.servo_period,
          {counts_on_mass(p) ? spec.least_friction : 0.0, spec.position_resolution}};
}

double largest_slew(double most, const SessionParameters& p) { return most / (0.5 * p.hold_time); }

ServoLaw::ServoLaw(const DeviceSpec& spec, const SessionParameters& in_force,
                   const ServoOptions& options)
    : parameters(in_force),
      bounding(bound_of(in_force, spec, options.scene_stiffness)),
      account(account_of(in_force, spec, options)),
      scene_change_gate(scene_change_gate_of(in_force, spec, bounding, account)),
      shapes(bounding_method(in_force.mode).shapes),
      counts_on_mass(feltwire::counts_on_mass(in_force)) {}

}  // namespace feltwire

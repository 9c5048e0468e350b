// Makes a servo from the parameters of a session: chooses its bound, account, observer and limits.
// Puts another law into one that runs.

#include <algorithm>
#include <sstream>
#include <stdexcept>
#include <utility>

#include "client/servo/servo.hpp"
#include "core/bounding/device_account.hpp"

namespace feltwire {
namespace {

// Samples remembered for their reply: 8 s at 1 kHz, 0.8 s at 10 kHz. A later reply still counts as
// answered and late.
constexpr std::size_t kRemembered = 8192;

bool admits_reduction(const SessionParameters& parameters) {
  return bounding_method(parameters.mode).admits_reduction;
}

BoundingConfig bound_of(const SessionParameters& parameters, const DeviceSpec& spec,
                        double scene_stiffness) {
  validate(spec);
  validate(parameters);
  BoundingConfig config = bounding_config(parameters, spec);
  if (scene_stiffness > 0.0) config.stiffness = scene_stiffness;
  // The server bounds. Only the safety clamps remain here, which every mode has.
  if (parameters.side == BoundingSide::server) config.mode = kUnbounded;
  return config;
}

/// Why the account alone makes the force passive, as a part of a sentence; null if it does not.
const char* needs_account(const SessionParameters& p) {
  if (p.mode == kUnbounded) return nullptr;
  if (p.side == BoundingSide::server) return " of a bound at the server";
  if (p.operator_damping > 0.0) return " with an operator's damping";
  return bounding_method(p.mode).shapes ? "" : nullptr;
}

/// Whether the account counts on the device's mass and dry friction, and on the hand's largest
/// force: it does with a method that shapes, or that was told of the operator's damping.
bool counts_on_mass(const SessionParameters& p) {
  return p.side != BoundingSide::server && needs_account(p) != nullptr;
}

/// With a method that only shapes, or that counts on the operator's damping, only the account makes
/// the port passive. A bound at the server also has an account, because that bound ignores delay,
/// loss and late ticks. So has every bound at this side: it counts on holds of T, and some of the
/// papers' bounds are not passive by themselves. There is no account if nothing bounds, or if
/// nothing of the device is known.
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

/// The observer counts what the device itself burns, whatever the bound may credit. It counts dry
/// friction if the account does.
PortEnergy observer_of(const DeviceSpec& spec, const SessionParameters& p) {
  return {spec.damping,
          spec.rotation_actuated > 0 ? spec.rotational_damping : Damping(),
          p.servo_period,
          {counts_on_mass(p) ? spec.least_friction : 0.0, spec.position_resolution}};
}

/// [N/s], [N m/s] for a force or torque that only a change of the scene causes: all of it in half
/// the hold time, as fast as a fade removes it.
double largest_slew(double most, const SessionParameters& p) { return most / (0.5 * p.hold_time); }

/// Only a scene change gate withholds a changed scene's force, and makes sure that the hand pays
/// for it.
std::optional<SceneChangeGate> scene_change_gate_of(const SessionParameters& p,
                                                    const DeviceSpec& spec,
                                                    const Bounding& bounding,
                                                    const std::optional<PortAccount>& account) {
  if (!bounding.takes_endowment() || !account || p.operator_damping > 0.0) return std::nullopt;
  return SceneChangeGate(largest_slew(spec.max_force, p));
}

/// The robot's contact is rendered like the local model.
std::optional<RemoteHand> remote_of(const ServoOptions& options, const SessionParameters& p) {
  if (!options.leads) return std::nullopt;
  if (!p.local_model)
    throw std::invalid_argument(
        "a hand that leads a robot needs the local model: ask for local_model");
  return RemoteHand(*options.leads, 0.5 * p.hold_time, options.seat);
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

}  // namespace

void validate(const ServoOptions& options, const SessionParameters& parameters) {
  const SafetyLimits& s = options.safety;
  validate(s);
  if (const char* why = needs_account(parameters); why != nullptr && !options.account)
    throw std::invalid_argument("the force of the mode " + parameters.mode + why +
                                " is passive by the account alone; keep the account, or choose a "
                                "mode of a paper at the client");
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
  // A bound also lets nothing through at first. Force that a ramp withholds behind it comes back
  // only as the hand presses deeper (measured).
  const bool client_bounds =
      parameters.side != BoundingSide::server && parameters.mode != kUnbounded;
  if (!client_bounds) options.safety.ramp_up = 0.2;  // [s]
  return options;
}

ServoLaw::ServoLaw(const DeviceSpec& spec, const SessionParameters& in_force,
                   const ServoOptions& options)
    : parameters(in_force),
      bounding(bound_of(in_force, spec, options.scene_stiffness)),
      account(account_of(in_force, spec, options)),
      scene_change_gate(scene_change_gate_of(in_force, spec, bounding, account)),
      shapes(bounding_method(in_force.mode).shapes),
      counts_on_mass(feltwire::counts_on_mass(in_force)) {}

Servo::Servo(const DeviceSpec& spec, const SessionParameters& parameters,
             const ServoOptions& options)
    : spec_(spec),
      options_(options),
      law_(spec, parameters, options),
      safety_(options.safety, admits_reduction(parameters)),
      port_(observer_of(spec, parameters)),
      reserve_(parameters.servo_period),
      owed_(std::max(0.0, options.owed)),
      forgiven_(-owed_),
      torque_(law_.bounding.config().rotation),
      period_(law_.bounding.config().period),
      measures_(law_.bounding.config().period),
      velocity_(parameters.velocity_cutoff),
      rise_(largest_slew(spec.max_force, parameters), largest_slew(spec.max_torque, parameters)),
      remote_(remote_of(options, parameters)),
      wanted_seat_(options.seat),
      moves_(position_bounds(spec, options.motion_scale)),
      turns_(rotation_bounds(spec)),
      actuation_lag_(spec.late_ticks),
      sent_(kRemembered) {
  validate(options, parameters);
  if (law_.account) law_.account->begin_in_debt(owed_);
}

void Servo::adopt(ServoLaw& next) noexcept {
  next_law_ = &next;
  if (holds())
    start_letting_go();
  else
    exchange_law();
}

/// Precondition: no force is given. A late device may still hold some.
void Servo::exchange_law() noexcept {
  owed_ = owed();
  std::swap(law_, *next_law_);
  const std::optional<PortAccount>& before = next_law_->account;
  if (law_.account && before)
    law_.account->go_on_from(*before);
  else if (law_.account)
    law_.account->begin_in_debt(owed_);
  // Count at least what the account counts.
  if (law_.counts_on_mass) port_.count_friction(spec_.least_friction);
  next_law_ = nullptr;
  if (scene_was_changed_) law_.bounding.scene_changed();  // it was made with the join's data
  rise_.given({});
  forget_surfaces();
  newest_.command = {};
  newest_.predicted = false;
  // The account may pay for a whole force at once. That must not throw a hand that has sunk in.
  safety_.begin_anew();
}

}  // namespace feltwire

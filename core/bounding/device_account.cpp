#include "core/bounding/device_account.hpp"

namespace feltwire {

AccountConfig account_config(const DeviceSpec& spec, double period) {
  AccountConfig account;
  account.period = period;
  account.translation = {.damping = spec.damping,
                         .coulomb_friction = spec.least_friction,
                         .quantum = spec.position_resolution,
                         .mass = spec.least_mass,
                         .outside_force = spec.hand_force};
  account.late = spec.actuation.late_ticks;
  account.lag = {.time = spec.actuation.lag, .kind = spec.actuation.kind};
  if (spec.hand_speed > 0.0) account.translation.speed = spec.hand_speed;
  if (spec.rotation_actuated > 0) {
    account.rotation.damping = spec.rotational_damping;
    account.rotation.quantum = spec.rotation.resolution;
    account.rotation.mass = spec.rotation.least_inertia;
    if (spec.rotation.hand_torque > 0.0) account.rotation.outside_force = spec.rotation.hand_torque;
  }
  const bool turns = account.rotation.damping.least() > 0.0 || account.rotation.mass > 0.0;
  const Command largest{.elastic = Vec3(spec.max_force, 0.0, 0.0),
                        .torque = Vec3(turns ? spec.max_torque : 0.0, 0.0, 0.0)};
  account.cap = kAccountCap * need_at_rest(account, largest);
  return account;
}

AccountConfig any_hand_account(const DeviceSpec& spec, double period) {
  AccountConfig account;
  account.period = period;
  account.translation.damping = spec.damping;
  if (spec.rotation_actuated > 0) account.rotation.damping = spec.rotational_damping;
  account.late = spec.actuation.late_ticks;
  account.lag = {.time = spec.actuation.lag, .kind = spec.actuation.kind};
  account.looks_ahead = false;
  return account;
}

}  // namespace feltwire

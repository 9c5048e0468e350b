#pragma once
// The bound and the account of a session, as one object that can be exchanged in a running servo.

#include <optional>

#include "client/servo/scene_change_gate.hpp"
#include "client/servo/servo_options.hpp"
#include "core/bounding/account.hpp"
#include "core/bounding/bounding.hpp"
#include "core/bounding/port_energy.hpp"
#include "core/device/device_spec.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// Whether the session's method may be followed by limits that reduce its force.
bool admits_reduction(const SessionParameters& parameters);

/// Why the account alone makes the force passive, as a part of a sentence; null if it does not.
const char* needs_account(const SessionParameters& parameters);

/// The observer of the port, which counts what the account counts on.
PortEnergy observer_of(const DeviceSpec& spec, const SessionParameters& parameters);

/// [N/s], [N m/s] for a force or torque that only a change of the scene causes: all of it in half
/// the hold time, as fast as a fade removes it.
double largest_slew(double most, const SessionParameters& parameters);

/// The bound of a servo as one object. A law is made where memory may be allocated; then it is
/// exchanged into a running servo, which allocates none (Servo::adopt()).
struct ServoLaw {
  /// Throws std::invalid_argument that names the parameter and the remedy.
  ServoLaw(const DeviceSpec& spec, const SessionParameters& in_force, const ServoOptions& options);
  SessionParameters parameters;  // in force with this law
  Bounding bounding;
  std::optional<PortAccount> account;
  std::optional<SceneChangeGate> scene_change_gate;  // if this side bounds by contact_frame
  bool shapes, counts_on_mass;
};

}  // namespace feltwire

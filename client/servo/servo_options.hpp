#pragma once
// Options of a servo beside its bound, as its program chooses them.

#include <cstdint>
#include <optional>
#include <string>
#include <vector>

#include "client/servo/remote_hand.hpp"
#include "core/safety/safety.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire {

struct ServoOptions {
  /// Between the bound and the device. None by default, so that measurements show the bound;
  /// protect_hand() gives the limits for a person's hand.
  SafetyLimits safety;
  bool observes = false;  // its role gets no force: used for the no-force reason
  /// The account stands behind the law. False: a law of a paper as it was published.
  bool account = true;
  bool learns_hand_force = false;  // the account relies on the largest recent force from
                                   // outside (core/bounding/hand_force_bound.hpp)
  /// The hand leads the scene's robot, and trusts this share of the energy that the robot reports.
  /// Needs a local model.
  std::optional<RemoteTrust> leads{};
  /// Names of the scene's seats for robots, in the order of JoinAccepted, and the number of the one
  /// whose robot the hand leads first.
  std::vector<std::string> seats{};
  std::uint8_t seat = 0;
  /// The button of the device, from 1, that chooses the next robot; 0: none.
  int seat_button = 0;
  double motion_scale = 1.0;     // Device::motion_scale()
  double owed = 0.0;             // [J] debt of the device's account when the servo begins
  double scene_stiffness = 0.0;  // [N/m] of the stiffest surface, for methods that shape; 0: not
                                 // known
};

/// Throws std::invalid_argument that names the limit, its value and the remedy: a slew, ramp or
/// speed limit cannot follow a bound that does not admit reductions, at the client or the server;
/// a force cannot do without the account where nothing else makes it passive.
void validate(const ServoOptions& options, const SessionParameters& parameters);

/// The safety limits that protect a hand and are not felt in normal use (docs/devices.md has the
/// measurements): the wait for a small force; the speed limit, if the session's bound admits it; a
/// ramp, if the client does not bound.
ServoOptions protect_hand(const SessionParameters& parameters);

}  // namespace feltwire

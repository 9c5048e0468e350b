#pragma once
// The hand's side of leading a robot: the enabling switch, the gripper, the choice of the robot,
// and the force of what the robot touches.

#include <cstdint>
#include <optional>
#include <string_view>

#include "client/device/device.hpp"
#include "client/servo/remote_hand.hpp"
#include "client/servo/servo_options.hpp"
#include "core/teleoperation/link_states.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

class RobotLead {
 public:
  /// Precondition: `options.leads`. `fade` [s]: RemoteHand's.
  RobotLead(const ServoOptions& options, double fade)
      : hand_(*options.leads, fade, options.seat), wanted_seat_(options.seat) {}

  /// Takes the switch, the gripper and the button of a tick. `free`: the hand may lead.
  void take(const DeviceReading& reading, bool free, const ServoOptions& options) noexcept;
  /// Takes a reply. `state`: our time of the state that the reply describes; `arrival`: of the
  /// reply; `hold_time` [s]: the oldest age of the robot's data that is believed.
  void take(const Reply& reply, Nanoseconds state, Nanoseconds arrival, double hold_time) noexcept;
  /// Returns the force of the objects that the robot touches, in addition to the scene's.
  Command touch(const Tool& tool, const Command& scene, Nanoseconds now, double elapsed) noexcept {
    return hand_.touch(tool, scene, seconds(now - state_time_), elapsed);
  }
  /// The part of the last tick for the robot.
  Lead lead() const noexcept { return hand_.lead(deadman_, gripper_); }

  RemoteHand& hand() noexcept { return hand_; }
  const RemoteHand& hand() const noexcept { return hand_; }
  /// The states between this hand and its robot so far.
  const LinkStates& states() const noexcept { return states_; }

 private:
  RemoteHand hand_;
  LinkStates states_;
  Nanoseconds state_time_{0};      // our time of the robot's state
  bool deadman_ = false;           // in the last tick
  std::uint8_t wanted_seat_;       // of the robot that the hand wants to lead
  bool seat_pressed_ = false;      // the button that chooses another, in the last tick
  std::optional<double> gripper_;  // [m] in the last tick
};

}  // namespace feltwire

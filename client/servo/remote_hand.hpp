#pragma once
// The force on a hand that leads a robot, and the data that it sends to the robot.

#include <cmath>
#include <optional>

#include "client/servo/robot_walls.hpp"
#include "core/base/types.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/surface_index.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// The remote contact as a local model, where the hand meets it (docs/teleoperation.md), and the
/// walls of the robot's workspace (RobotWalls). What all this commands goes through the bound, the
/// account and the safety limits like any command. Nothing here allocates, throws or reads a clock.
class RemoteHand {
 public:
  /// `trust`: how much the account is credited of what the robot says that its environment gave.
  /// `fade` [s] > 0: the force of a contact that is no more falls to nothing in this time.
  RemoteHand(const RemoteTrust& trust, double fade) : walls_(fade), energy_(trust), fade_(fade) {}

  /// Takes what the newest reply says of the robot.
  void take(const Remote& remote) noexcept;
  /// Forgets what was said: the hand may be anywhere.
  void forget() noexcept;

  /// The hand moved by `displacement` [m] to `hand` in `elapsed` [s] while `held` [N] was on it.
  /// Returns what the account is to be credited [J].
  double step(const Vec3& hand, const Vec3& displacement, const Vec3& held,
              double elapsed) noexcept;

  /// The robot's contact and the walls of its workspace at the tool, which the scene answers
  /// `beside`. `age` [s] of what was taken.
  Command touch(const Tool& tool, const Command& beside, double age, double elapsed) noexcept;

  /// `deadman`: the switch is held now. `gripper` [m] that the hand means; what is not finite or
  /// below zero says nothing.
  Lead lead(bool deadman, std::optional<double> gripper) const noexcept {
    return {.deadman = deadman,
            .known_surface = index_.known_surface(),
            .offset = index_.offset(),
            .hand_work = hand_work_,
            .gripper = gripper && *gripper >= 0.0 && *gripper <= kMaxPosition ? *gripper : -1.0};
  }

  const Remote& remote() const noexcept { return remote_; }
  /// [N] that the force of touch() may rise by while the tool moves by `way` [m].
  double may_rise(double way, double elapsed) const noexcept;

 private:
  void show(const Vec3& hand) noexcept;

  SurfaceIndex index_;
  LocalContact local_;
  RobotWalls walls_;
  RemoteEnergy energy_;
  Remote remote_;
  double fade_;
  double weight_ = 0.0;     // of the contact's force, 0 to 1
  double share_ = 0.0;      // of the remote contact in the newest command
  bool pushing_ = false;    // the newest command had some of it
  double hand_work_ = 0.0;  // [J]
};

}  // namespace feltwire

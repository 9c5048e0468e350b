#pragma once
// The force on a hand that leads a robot, and the data that it sends to the robot.

#include <cmath>
#include <optional>

#include "client/servo/robot_walls.hpp"
#include "core/base/types.hpp"
#include "core/local_model/local_contact.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/surface_offset.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// The remote contact as a local model at the hand (docs/teleoperation.md), and the walls of the
/// robot's workspace (RobotWalls). Their command goes through the bound, the account and the safety
/// limits like any command. No function allocates, throws or reads a clock.
class RemoteHand {
 public:
  /// `trust`: the share of the robot's reported energy that is credited to the account. `fade` [s]
  /// > 0: the force of an ended contact falls to zero in this time. `seat`: of the robot.
  RemoteHand(const RemoteTrust& trust, double fade, std::uint8_t seat = 0)
      : walls_(fade), energy_(trust), seat_(seat), fade_(fade) {}

  /// Takes the newest reply's data of the robot. Data of another robot count as none.
  void take(const Remote& remote) noexcept;
  /// From now on it leads the robot on that seat, and forgets the one before. Precondition: the
  /// switch is released, and pushes() is false.
  void lead_another(std::uint8_t seat) noexcept;
  std::uint8_t seat() const noexcept { return seat_; }
  /// Whether a contact of the robot or a wall of its workspace may push the hand.
  bool pushes() const noexcept { return weight_ > 0.0 || walls_.pushes(); }
  /// Forgets these data: the hand may be anywhere.
  void forget() noexcept;

  /// The hand moved by `displacement` [m] to `hand` in `elapsed` [s] while `held` [N] was on it.
  /// Returns the credit of the account [J].
  double step(const Vec3& hand, const Vec3& displacement, const Vec3& held,
              double elapsed) noexcept;

  /// Returns the robot's contact and the walls of its workspace at the tool. `beside` is the
  /// scene's command, `age` [s] the age of the taken data.
  Command touch(const Tool& tool, const Command& beside, double age, double elapsed) noexcept;

  /// `deadman`: the switch is held now. `gripper` [m] is the wanted opening; a value that is not
  /// finite or is below zero is ignored.
  Lead lead(bool deadman, std::optional<double> gripper) const noexcept {
    return {.deadman = deadman,
            .known_surface = surface_offset_.known_surface(),
            .offset = surface_offset_.offset(),
            .hand_work = hand_work_,
            .gripper = gripper && *gripper >= 0.0 && *gripper <= kMaxPosition ? *gripper : -1.0,
            .seat = seat_};
  }

  const Remote& remote() const noexcept { return remote_; }
  /// [N] by which the force of touch() may rise while the tool moves by `way` [m].
  double may_rise(double way, double elapsed) const noexcept;

 private:
  void show(const Vec3& hand) noexcept;

  SurfaceOffset surface_offset_;
  LocalContact local_;
  RobotWalls walls_;
  RemoteEnergy energy_;
  Remote remote_;
  std::uint8_t seat_;
  double fade_;
  double weight_ = 0.0;     // of the contact's force, 0 to 1
  double share_ = 0.0;      // of the remote contact in the newest command
  bool pushing_ = false;    // the newest command had a part of it
  double hand_work_ = 0.0;  // [J]
};

}  // namespace feltwire

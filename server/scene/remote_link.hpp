#pragma once
// The link of a hand and a robot in one scene: from the hand's samples to the robot's targets, and
// back. It has no socket and no clock.

#include <array>
#include <cstdint>
#include <optional>

#include "core/scene/scene.hpp"
#include "core/teleoperation/authority.hpp"
#include "core/teleoperation/engage_index.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/scene_view.hpp"

namespace feltwire {

/// Keeps the newest values and the state. There is no queue: a sample makes the target, and an
/// older one is never used again. Never allocates.
class RemoteLink {
 public:
  /// The hand is silent after this time without a sample, the robot without a state.
  static constexpr Nanoseconds kSilence = std::chrono::milliseconds(100);
  /// A connected robot gets a message of the server at least this often.
  static constexpr Nanoseconds kBetweenTargets = std::chrono::milliseconds(10);
  /// A hand counts as jumping if it moved this many times as far as the speed limit allows.
  static constexpr double kJump = 5.0;

  /// A wall of the workspace is sent to the hand while it is nearer to the target than this [m].
  static constexpr double kToldWall = 0.5;

  explicit RemoteLink(const RemoteSeat& seat) : seat_(seat), index_(seat.scale) {}

  /// A robot takes the seat. Hands and robots are numbered in one sequence, from 1. `own`: its
  /// limits in addition to those of the seat.
  void sit(std::uint32_t robot, const Workspace& own = {}) noexcept;
  /// A hand or a robot has left.
  void leave(std::uint32_t number) noexcept;
  bool taken() const noexcept { return robot_ != 0; }

  /// At most so many hands wait for the lead; others are ignored.
  static constexpr std::size_t kMostWaiting = 8;

  /// The newest sample of a hand that leads or wants to, received at `now`. The first hand leads.
  /// It hands over to the next one that presses its switch, while its own is released or it is
  /// silent; that one must have shown a released switch before. It engages at the robot's present
  /// target, as every hand does. Samples of the others change nothing. Precondition: the batch was
  /// taken, and has a lead. `period` [s] of the hand's servo.
  void lead(std::uint32_t hand, const SampleBatch& batch, double period, Nanoseconds now) noexcept;
  /// The robot's state, received at `now`; false: it is not newer than the one before.
  bool follow(const RobotState& state, Nanoseconds now) noexcept;

  /// The `remote` of the reply to that hand. For a hand that leads no robot: disabled.
  Remote told(std::uint32_t hand, Nanoseconds now) const noexcept;

  /// For observers. Empty: there is no robot, or it has sent nothing yet.
  std::optional<SeenRobot> seen(Nanoseconds now) const noexcept;

  /// Whether there is a target to send: a new one, or none was sent for kBetweenTargets.
  bool target_due(Nanoseconds now) const noexcept {
    return robot_ != 0 && (fresh_ || (answers_ && now - sent_at_ >= kBetweenTargets));
  }
  /// Returns the target, and counts it as sent.
  RobotTarget target(Nanoseconds now) noexcept;

  LinkState state() const noexcept { return authority_.state(); }

 private:
  bool jumped(const Sample& sample, double period) const noexcept;
  bool asks(std::uint32_t hand, bool pressed) noexcept;
  void stop_waiting(std::uint32_t hand) noexcept;
  void hand_over(std::uint32_t hand, const Sample& newest, Nanoseconds now) noexcept;
  void step(bool refused, Nanoseconds now) noexcept;
  void tell_walls(Remote& remote) const noexcept;

  RemoteSeat seat_;
  Authority authority_;
  EngageIndex index_;
  WorkspaceLimit limit_;
  std::uint32_t robot_ = 0, hand_ = 0;  // 0: none
  Sample sample_;                       // the hand's newest; index 0: none yet
  Lead lead_;
  double work_ = 0.0;  // [J] paid by all hands while they led
  Nanoseconds hand_heard_{0};
  struct Waiting {
    std::uint32_t hand = 0;  // 0: none
    bool released = false;   // its newest sample's switch
  };
  std::array<Waiting, kMostWaiting> waiting_{};
  RobotState said_;  // sent by the robot; index 0: nothing yet
  Nanoseconds robot_heard_{0};
  Pose wanted_;           // in the robot's frame, while engaged
  bool fresh_ = false;    // there is a target that has not been sent
  bool answers_ = false;  // the robot has sent a state since
  Nanoseconds sent_at_{0};
  std::uint64_t targets_ = 0;
};

}  // namespace feltwire

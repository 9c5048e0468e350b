#pragma once
// The link of a hand and a robot in one scene: from the hand's samples to the robot's targets, and
// back. It has no socket and no clock.

#include <array>
#include <cstdint>
#include <optional>

#include "core/scene/scene.hpp"
#include "core/teleoperation/lead_engagement.hpp"
#include "core/teleoperation/shared_clutch_offset.hpp"
#include "core/teleoperation/steady_switch.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/scene_view.hpp"

namespace feltwire {

/// Keeps the newest values and the state. There is no queue: a sample makes the target, and an
/// older one is never used again. Never allocates.
class TeleopLink {
 public:
  /// The hand is silent after this time without a sample, the robot without a state.
  static constexpr Nanoseconds kSilence = std::chrono::milliseconds(100);
  /// A connected robot gets a message of the server at least this often.
  static constexpr Nanoseconds kBetweenTargets = std::chrono::milliseconds(10);
  /// A hand counts as jumping if it moved this many times as far as the speed limit allows.
  static constexpr double kJump = 5.0;

  /// A wall of the workspace is sent to the hand while it is nearer to the target than this [m].
  static constexpr double kWallRange = 0.5;

  /// So many hands may lead at the same time, each with a share.
  static constexpr std::size_t kMostLeaders = SharedClutchOffset::kMost;

  explicit TeleopLink(const RemoteSeat& seat)
      : seat_(seat), clutch_(seat.scale, seat.force_scale) {}

  /// A robot takes the seat. Hands and robots are numbered in one sequence, from 1. `own`: its
  /// limits in addition to those of the seat.
  void seat_robot(std::uint32_t robot, const Workspace& own = {}) noexcept;
  /// A hand or a robot has left.
  void leave(std::uint32_t number) noexcept;
  bool taken() const noexcept { return robot_ != 0; }
  const RemoteSeat& seat() const noexcept { return seat_; }

  /// At most so many hands wait for the lead; others are ignored.
  static constexpr std::size_t kMostWaiting = 8;

  /// The newest sample of a hand that leads or wants to, received at `now`. Precondition: the batch
  /// was taken, and has a lead. `period` [s] of the hand's servo.
  ///
  /// `share` 0: the hand leads alone. The first such hand leads. It hands over to the next one that
  /// presses its switch, while its own is released or it is silent; that one must have shown a
  /// released switch before. It engages at the robot's present target, as every hand does. Samples
  /// of the others change nothing.
  /// `share` > 0: the hand leads together with others that have a share. Each has its own switch
  /// and state. The weight of an engaged hand is its share over the sum of the engaged ones
  /// (SharedClutchOffset). The target's first step is zero when a hand engages, releases, leaves or
  /// gets another share. A hand that gets the share 0 while others have a seat loses its seat. A
  /// switch that flickers counts as released (SteadySwitch), so that it neither keeps the lead from
  /// another hand nor changes the weights all the time.
  void lead(std::uint32_t hand, const SampleBatch& batch, double period, Nanoseconds now,
            double share = 0.0) noexcept;
  /// The robot's state, received at `now`; false: it is not newer than the one before.
  bool follow(const RobotState& state, Nanoseconds now) noexcept;

  /// The `remote` of the reply to that hand, with its own state. For a hand that leads no robot:
  /// disabled.
  Remote reply_for(std::uint32_t hand, Nanoseconds now) const noexcept;

  /// Whether that hand moves the robot.
  bool engages(std::uint32_t hand) const noexcept;

  /// Whether view() has a robot.
  bool visible() const noexcept { return robot_ != 0 && robot_state_.index != 0; }
  /// For observers. Empty: there is no robot, or it has sent nothing yet.
  std::optional<SeenRobot> view(Nanoseconds now) const noexcept;

  /// Whether there is a target to send: a new one, or none was sent for kBetweenTargets.
  bool target_due(Nanoseconds now) const noexcept {
    return robot_ != 0 && (fresh_ || (answers_ && now - sent_at_ >= kBetweenTargets));
  }
  /// Returns the target, and counts it as sent.
  RobotTarget target(Nanoseconds now) noexcept;

  /// The first of these states that any leader has: engaged, clutched, hold, ready, aligning,
  /// fault, disabled.
  LinkState state() const noexcept;

 private:
  struct Leader {
    std::uint32_t hand = 0;  // 0: none
    double share = 0.0;      // 0: it leads alone
    LeadEngagement engagement;
    Sample sample;  // its newest; index 0: none yet
    Lead lead;
    SteadySwitch deadman;  // what lead.deadman has been
    Nanoseconds heard{0};

    bool engaged() const noexcept { return engagement.state() == LinkState::engaged; }
    bool silent(Nanoseconds now) const noexcept { return now - heard > kSilence; }
    /// The intended place of the robot, less the offset of the leader.
    Pose robot_pose() const noexcept {
      return {sample.pose.position - lead.offset, sample.pose.orientation};
    }
  };
  /// The target that a hand engages at.
  const Pose& present() const noexcept {
    return grouped_ == std::array<double, kMostLeaders>{} ? robot_state_.commanded : wanted_;
  }
  Vec3 turn_missing(const Leader& leader) const noexcept {
    return seat_.aligned->missing(leader.sample.pose.orientation, present().orientation);
  }
  bool jumped(const Leader& leader, const Sample& sample, double period) const noexcept;
  bool requests_lead(std::uint32_t hand, bool pressed) noexcept;
  void stop_waiting(std::uint32_t hand) noexcept;
  bool others_lead(const Leader& leader) const noexcept;
  Leader* seat_of(std::uint32_t hand) noexcept;
  Leader* admit(std::uint32_t hand, double share, const Sample& newest, bool pressed,
                Nanoseconds now) noexcept;
  Leader* transfer_lead(std::uint32_t hand, double share, const Sample& newest,
                        Nanoseconds now) noexcept;
  void step(Leader& leader, bool refused, Nanoseconds now) noexcept;
  void regroup() noexcept;
  void move(std::size_t leader) noexcept;
  std::uint32_t known_surface() const noexcept;
  double gripper() const noexcept;
  std::size_t first() const noexcept;
  void add_walls(Remote& remote, const ClutchOffset& clutch) const noexcept;

  RemoteSeat seat_;
  SharedClutchOffset clutch_;
  WorkspaceLimit limit_;
  std::uint32_t robot_ = 0;  // 0: none
  std::array<Leader, kMostLeaders> leaders_{};
  std::array<double, kMostLeaders> grouped_{};  // the weights that clutch_ began with
  double work_ = 0.0;  // [J] that hands paid since they began to lead, in the robot's measure
  struct Waiting {
    std::uint32_t hand = 0;  // 0: none
    bool released = false;   // its newest sample's switch
  };
  std::array<Waiting, kMostWaiting> waiting_{};
  RobotState robot_state_;  // sent by the robot; index 0: nothing yet
  Nanoseconds robot_time_{0};
  Pose wanted_;           // in the robot's frame, while engaged
  bool fresh_ = false;    // there is a target that has not been sent
  bool answers_ = false;  // the robot has sent a state since
  Nanoseconds sent_at_{0};
  std::uint64_t targets_ = 0;
};

}  // namespace feltwire

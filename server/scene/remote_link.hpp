#pragma once
// A hand and a robot in one scene: from the hand's samples to the robot's targets, and back. No
// socket, no clock.

#include <array>
#include <cstdint>
#include <optional>

#include "core/scene/scene.hpp"
#include "core/teleoperation/authority.hpp"
#include "core/teleoperation/shared_index.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/scene_view.hpp"

namespace feltwire {

/// The newest of everything, and the state. There is no queue: a sample makes the target, and an
/// older one is never used again. Never allocates.
class RemoteLink {
 public:
  /// The hand is silent after this time without a sample, the robot without a state.
  static constexpr Nanoseconds kSilence = std::chrono::milliseconds(100);
  /// A robot that is here hears of the server at least that often.
  static constexpr Nanoseconds kBetweenTargets = std::chrono::milliseconds(10);
  /// A hand jumped that moved so many times as far as the speed allows.
  static constexpr double kJump = 5.0;

  /// A wall of the workspace is told to the hand while it is nearer to the target than this [m].
  static constexpr double kToldWall = 0.5;

  /// So many hands may lead at the same time, each with a share.
  static constexpr std::size_t kMostLeaders = SharedIndex::kMost;

  explicit RemoteLink(const RemoteSeat& seat) : seat_(seat), index_(seat.scale) {}

  /// A robot sits down; hands and robots are numbered alike, from 1. `own`: limits that it has
  /// beside those of the seat; both hold.
  void sit(std::uint32_t robot, const Workspace& own = {}) noexcept;
  /// A hand or a robot is gone.
  void leave(std::uint32_t number) noexcept;
  bool taken() const noexcept { return robot_ != 0; }

  /// At most so many hands wait for the lead; more are not heard.
  static constexpr std::size_t kMostWaiting = 8;

  /// The newest sample of a hand that leads or would, which came at `now`. Precondition: the batch
  /// was taken, and has a lead. `period` [s] of the hand's servo.
  ///
  /// `share` 0: it leads alone. The first such hand leads. It hands over to the next one that
  /// presses its switch, while its own is released or it is silent: that one must have shown a
  /// released switch before. It engages where the robot's target is, as every hand that engages.
  /// What the others say changes nothing.
  /// `share` > 0: it leads together with others that have one, each with a switch and a state of
  /// its own; of those that are engaged each has its share over their sum (SharedIndex). Whoever
  /// engages, lets go, leaves or gets another share, the target's first step is zero.
  void lead(std::uint32_t hand, const SampleBatch& batch, double period, Nanoseconds now,
            double share = 0.0) noexcept;
  /// The robot's state, which came at `now`; false: it is not newer than the one before.
  bool follow(const RobotState& state, Nanoseconds now) noexcept;

  /// The `remote` of the reply to that hand, with its own state. For a hand that leads no robot:
  /// disabled.
  Remote told(std::uint32_t hand, Nanoseconds now) const noexcept;

  /// For those who look on. Nothing: no robot sits there, or it has said nothing yet.
  std::optional<SeenRobot> seen(Nanoseconds now) const noexcept;

  /// Whether there is a target to send: a new one, or none went for kBetweenTargets.
  bool target_due(Nanoseconds now) const noexcept {
    return robot_ != 0 && (fresh_ || (answers_ && now - sent_at_ >= kBetweenTargets));
  }
  /// The target; it counts as sent.
  RobotTarget target(Nanoseconds now) noexcept;

  /// Of all that lead, the state that comes first among: engaged, clutched, hold, ready, fault,
  /// disabled.
  LinkState state() const noexcept;

 private:
  struct Leader {
    std::uint32_t hand = 0;  // 0: none
    double share = 0.0;      // 0: it leads alone
    Authority authority;
    Sample sample;  // its newest; index 0: none yet
    Lead lead;
    Nanoseconds heard{0};

    bool engaged() const noexcept { return authority.state() == LinkState::engaged; }
    bool silent(Nanoseconds now) const noexcept { return now - heard > kSilence; }
    /// Where it is meant to be, less its offset.
    Pose meant() const noexcept {
      return {sample.pose.position - lead.offset, sample.pose.orientation};
    }
  };
  bool jumped(const Leader& leader, const Sample& sample, double period) const noexcept;
  bool asks(std::uint32_t hand, bool pressed) noexcept;
  void stop_waiting(std::uint32_t hand) noexcept;
  Leader* seat_of(std::uint32_t hand) noexcept;
  Leader* let_in(std::uint32_t hand, double share, const Sample& newest, bool pressed,
                 Nanoseconds now) noexcept;
  Leader* hand_over(std::uint32_t hand, double share, const Sample& newest,
                    Nanoseconds now) noexcept;
  void step(Leader& leader, bool refused, Nanoseconds now) noexcept;
  void regroup() noexcept;
  void move(std::size_t leader) noexcept;
  std::uint32_t known_surface() const noexcept;
  double gripper() const noexcept;
  std::size_t first() const noexcept;
  void tell_walls(Remote& remote, const EngageIndex& index) const noexcept;

  RemoteSeat seat_;
  SharedIndex index_;
  WorkspaceLimit limit_;
  std::uint32_t robot_ = 0;  // 0: none
  std::array<Leader, kMostLeaders> leaders_{};
  std::array<double, kMostLeaders> grouped_{};  // the weights that index_ began with
  double work_ = 0.0;  // [J] that hands paid since they began to lead, in the robot's measure
  struct Waiting {
    std::uint32_t hand = 0;  // 0: none
    bool released = false;   // its newest sample's switch
  };
  std::array<Waiting, kMostWaiting> waiting_{};
  RobotState said_;  // by the robot; index 0: nothing yet
  Nanoseconds robot_heard_{0};
  Pose wanted_;           // in the robot's frame, while engaged
  bool fresh_ = false;    // there is a target that has not been sent
  bool answers_ = false;  // the robot said something since
  Nanoseconds sent_at_{0};
  std::uint64_t targets_ = 0;
};

}  // namespace feltwire

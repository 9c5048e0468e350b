#pragma once
// A link between hands and a robot that follows exactly.

#include "server/scene/teleop_link.hpp"

namespace feltwire::teleop_link_test {

inline constexpr double kPeriod = 1e-3;  // [s]
inline constexpr std::uint32_t kRobot = 9;

struct Hand {
  std::uint32_t number;
  Vec3 at;
  bool pressed = false;
  double work = 0.0;  // [J]
  std::uint64_t index = 0;
  Vec3 offset = Vec3::Zero();  // [m]
  Quaternion turn = Quaternion::Identity();
  double share = 0.0;  // 0: leads alone
};

/// A link whose robot works and reaches its targets.
struct Bench {
  explicit Bench(const RemoteSeat& seat = {}, const Workspace& own = {}) : link(seat) {
    link.seat_robot(kRobot, own);
    state.commanded.position = state.pose.position = Vec3(0.4, 0.1, 0.3);
    say();
  }
  void say() {
    ++state.index;
    link.follow(state, now);
  }
  void send(Hand& hand) {
    now += std::chrono::milliseconds(1);
    say();
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0].index = ++hand.index;
    batch.samples[0].client_time = now;
    batch.samples[0].pose = {hand.at, hand.turn};
    batch.lead = Lead{.deadman = hand.pressed,
                      .known_surface = known_surface,
                      .offset = hand.offset,
                      .hand_work = hand.work};
    link.lead(hand.number, batch, kPeriod, now, hand.share);
    target = link.target(now);
    if (target.state == LinkState::engaged) state.commanded = target.pose;
  }
  void press(Hand& hand) {
    hand.pressed = false;
    send(hand);
    hand.pressed = true;
    send(hand);
  }
  LinkState told(const Hand& hand) const { return link.reply_for(hand.number, now).state; }

  TeleopLink link;
  RobotState state;
  RobotTarget target;
  Nanoseconds now = std::chrono::seconds(1);
  std::uint32_t known_surface = 0;  // the surface of the robot that all hands know
  Hand anna{1, Vec3(1.0, 0.0, 0.0)}, ben{2, Vec3(-3.0, 2.0, 1.0)};
};

}  // namespace feltwire::teleop_link_test

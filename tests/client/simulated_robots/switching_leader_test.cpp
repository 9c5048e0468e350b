// A single hand leads several robots in turn.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <string>
#include <variant>
#include <vector>

#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::switching_leader_test {
namespace {

using test::FollowerSession;
using test::HandSession;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using enum LinkState;

constexpr double kStep = 0.25e-3;  // [m] per sample at the robot's speed limit
// [N] the largest fall of the force per tick: the largest force ends within half the hold time, and
// the hand's own movement adds a part.
constexpr double kFall = 8.9 / 50.0 + 0.05;
constexpr RemoteTrust kTrust{.per_contact = 0.1, .power = 5.0};

Scene two_seats() {
  return test::empty_scene(std::vector{RemoteSeat{.name = "left"}, RemoteSeat{.name = "right"}});
}

struct BothRobots {
  PointRobot left_robot{test::wall_scene(2000.0), Vec3(0.0, 0.0, 0.02)};
  PointRobot right_robot{test::wall_scene(1000.0), Vec3(0.3, 0.0, 0.03)};
};

/// Two point robots, 20 and 30 mm in front of a wall.
struct TwoRobots : BothRobots, test::RobotSession {
  static constexpr std::uint64_t kRight = 0x801;

  explicit TwoRobots(const std::string& link = "delay=0",
                     const RemoteTrust& trust = {.per_contact = 0.0, .power = 0.0})
      : RobotSession(left_robot, link, two_seats(), trust),
        right(right_robot, kRight, link, 3, kStart) {
    other_robots.push_back(&right);
    seat(right, kRight, "right");
  }
  /// Presses the button for 50 ms.
  void press_button() {
    hand.buttons = 1;
    run(0.05);
    hand.buttons = 0;
  }
  const Remote& told() const { return servo.remote()->remote(); }
  FollowerSession right;
};

TEST(SwitchingLeader, LeadsOneRobotAfterTheOther) {
  for (const char* link : {"delay=0", "delay=50,jitter=3,loss=5,seed=6"}) {
    SCOPED_TRACE(link);
    TwoRobots bench(link);
    bench.engage();
    EXPECT_EQ(bench.state(0), engaged);
    EXPECT_NE(bench.state(1), engaged);
    bench.move(Vec3(0.0, 0.0, -0.045), 1.0);
    bench.run(1.0);
    EXPECT_NEAR(bench.force(), bench.left_robot.force().z(), 0.1 * bench.force());
    ASSERT_GE(bench.force(), 1.0);
    EXPECT_EQ(bench.servo.robot_name(), "left");

    bench.hand.pressed = false;
    bench.run(0.3);
    const Vec3 left = bench.commanded.position, right = bench.right.commanded.position;
    bench.press_button();
    bench.run(0.3);
    EXPECT_EQ(bench.servo.robot_name(), "right");
    EXPECT_EQ(bench.state(0), disabled) << "nobody leads it";
    EXPECT_EQ(bench.state(1), ready);
    EXPECT_EQ(bench.told().seat, 1);
    EXPECT_EQ(bench.servo.lead()->offset, Vec3::Zero());
    EXPECT_EQ(bench.servo.lead()->known_surface, 0u) << "those of the left robot mean nothing here";
    EXPECT_EQ(bench.force(), 0.0);

    bench.hand.pressed = true;
    bench.run(0.3);
    EXPECT_EQ(bench.state(1), engaged);
    EXPECT_LE((bench.right.commanded.position - right).norm(), 1e-4) << "nothing moved yet";
    bench.move(Vec3(0.0, 0.0, -0.06), 1.0);
    bench.run(1.0);
    ASSERT_GE(bench.force(), 1.0);
    EXPECT_NEAR(bench.force(), bench.right_robot.force().z(), 0.1 * bench.force());
    EXPECT_LE((bench.commanded.position - left).norm(), 1e-12) << "the left one holds where it was";
    EXPECT_EQ(bench.state(0), disabled);

    // The hand returns to the left robot. The surface must be at its former position.
    bench.hand.pressed = false;
    bench.run(0.3);
    bench.press_button();
    bench.run(0.3);
    bench.hand.pressed = true;
    bench.run(0.3);
    EXPECT_EQ(bench.state(0), engaged);
    EXPECT_EQ(bench.servo.robot_name(), "left");
    bench.move(Vec3(0.0, 0.0, -0.005), 0.5);
    bench.run(1.0);
    EXPECT_NEAR(bench.force(), bench.left_robot.force().z(), 0.1 * bench.force() + 0.1);

    EXPECT_LE(bench.farthest_step, kStep * (1.0 + 1e-9));
    EXPECT_LE(bench.right.farthest_step, kStep * (1.0 + 1e-9));
    EXPECT_LE(bench.fastest_fall, kFall);
    EXPECT_LE(bench.made(), 0.0);
  }
}

TEST(SwitchingLeader, TheButtonChangesNothingWhileTheSwitchIsHeld) {
  TwoRobots bench;
  bench.engage();
  bench.press_button();
  bench.run(0.2);
  EXPECT_EQ(bench.servo.robot_name(), "left");
  bench.hand.pressed = false;
  bench.run(0.2);
  EXPECT_EQ(bench.servo.robot_name(), "left") << "nor later";
  EXPECT_EQ(bench.state(1), disabled);
}

/// A client may name any robot number.
TEST(SwitchingLeader, TheServerKeepsAHandAtTheRobotThatItMoves) {
  TwoRobots bench;
  bench.engage();
  Sample sample = bench.servo.sample();
  const auto send = [&](std::uint8_t seat, bool pressed) {
    ++sample.index;
    bench.now += TwoRobots::kPeriod;
    bench.server->receive(
        bench.hand_datagrams.pack(
            sample, {},
            Lead{.deadman = pressed, .offset = bench.servo.lead()->offset, .seat = seat}),
        bench.hand_peer, bench.now, bench.room);
  };
  send(1, true);
  EXPECT_EQ(bench.state(0), engaged);
  EXPECT_EQ(bench.state(1), disabled);
  send(1, false);
  EXPECT_EQ(bench.state(0), clutched);
  send(1, false);
  EXPECT_EQ(bench.state(0), disabled);
  EXPECT_EQ(bench.state(1), ready);
  // The number does not exist, so the hand must lead no robot.
  send(9, false);
  EXPECT_EQ(bench.state(1), disabled);
  send(9, true);
  EXPECT_EQ(bench.state(0), disabled);
  EXPECT_EQ(bench.state(1), disabled);
  // A switch that stays pressed must not move the next robot.
  send(0, true);
  EXPECT_NE(bench.state(0), engaged);
}

/// Energy from one robot's environment must give no credit at another robot.
TEST(SwitchingLeader, BringsNoCreditAlong) {
  TwoRobots bench("delay=0", kTrust);
  bench.right.lie = [](RobotState& said) { said.energy.pushed = 1e3; };
  bench.engage();
  const double before = bench.servo.account()->balance();
  for (int i = 0; i < 20; ++i) {
    bench.hand.pressed = false;
    bench.run(0.1);
    bench.press_button();
    bench.run(0.1);
  }
  EXPECT_LE(bench.servo.account()->balance(), before + 1e-9);
  EXPECT_LE(bench.made(), 0.0);
}

TEST(SwitchingLeader, ARobotNeedsTheNameOfASeat) {
  TwoRobots bench;
  bench.server = std::make_unique<SceneSessions>(bench.scene, std::chrono::seconds(2), 8);
  const auto refusal = [&](const std::string& name) {
    return std::get<control::Refused>(bench.ask_to_join(0xa00, Role::follower, name)).reason;
  };
  EXPECT_THAT(refusal(""), HasSubstr("has several seats; choose with --seat: left, right"));
  EXPECT_THAT(refusal("up"), HasSubstr("has no seat 'up'; choose with --seat: left, right"));
  bench.seat(bench.right, TwoRobots::kRight, "right");
  EXPECT_THAT(refusal("right"), HasSubstr("the seat 'right' of scene 'empty' is taken"));
  const auto hand =
      std::get<control::JoinAccepted>(bench.ask_to_join(TwoRobots::kHand, Role::operator_));
  EXPECT_THAT(hand.seats, ElementsAre("left", "right"));
  const auto list = std::get<control::SessionDescriptions>(
      bench.server->answer(control::DescribeSessions{"empty", 0}, 0, {}, bench.now));
  ASSERT_EQ(list.sessions.size(), 2u);
  EXPECT_EQ(list.sessions[0].seat, "right");
  EXPECT_EQ(list.sessions[1].seat, "") << "it leads none yet";
}

TEST(SwitchingLeader, OneRobotThatLeavesTakesNothingFromTheOther) {
  TwoRobots bench;
  bench.engage();
  bench.server->answer(control::LeaveRequest{TwoRobots::kRight}, 0, {}, bench.now);
  bench.run(0.2);
  EXPECT_EQ(bench.state(0), engaged);
  bench.hand.pressed = false;
  bench.run(0.2);
  bench.press_button();
  bench.run(0.2);
  EXPECT_EQ(bench.told().state, disabled) << "its seat is empty";
  bench.seat(bench.right, 0x802, "right");
}

TEST(SwitchingLeader, AReloadWithTheSameSeatsKeepsThem) {
  TwoRobots bench;
  bench.engage();
  const Scene same = two_seats();
  EXPECT_TRUE(bench.server->enter(same, bench.now).empty());
  bench.run(0.1);
  EXPECT_NE(bench.state(0), engaged) << "the switch must be released once";
  bench.engage();
  EXPECT_EQ(bench.state(0), engaged);
  bench.move(Vec3(0.0, 0.0, -0.01), 0.3);
  EXPECT_EQ(bench.told().seat, 0);

  // Sessions of robots and leading hands store the number of the robot. If the scene's robots
  // change, none of these sessions may stay.
  const Scene other =
      test::empty_scene(std::vector{RemoteSeat{.name = "right"}, RemoteSeat{.name = "left"}});
  HandSession eye(0x900, "delay=0", 5, {.per_contact = 0.0, .power = 0.0});
  bench.join(0x900, Role::operator_);
  EXPECT_EQ(bench.server->enter(other, bench.now).size(), 3u);
  EXPECT_EQ(bench.server->size(), 1u) << "who leads nothing";
  EXPECT_EQ(bench.server->seats(), 2u);
  EXPECT_EQ(bench.server->link_state(0), disabled);
  const Scene none = test::empty_scene(std::vector<RemoteSeat>{});
  EXPECT_TRUE(bench.server->enter(none, bench.now).empty());
  EXPECT_EQ(bench.server->seats(), 0u);
  bench.server->answer(control::LeaveRequest{0x900}, 0, {}, bench.now);
}

TEST(SwitchingLeader, AnObserverSeesEachRobotInTurn) {
  TwoRobots bench;
  bench.engage();
  Picture picture;
  bench.server->draw(picture, bench.now);
  ASSERT_EQ(picture.robots.size(), 2u);
  EXPECT_EQ(picture.robots[0].seat, 0);
  EXPECT_EQ(picture.robots[0].state, engaged);
  EXPECT_EQ(picture.robots[1].seat, 1);
  EXPECT_EQ(picture.robots[1].seats, 3);

  const std::uint64_t id = 0x900;
  DatagramSession datagrams(id, test::keys(id), bench.parameters, false);
  bench.server->answer(
      control::JoinRequest{"eye", "empty", bench.hand.spec(), bench.parameters, Role::observer}, id,
      test::keys(id), bench.now);
  Sample sample;
  const auto look = [&] {
    ++sample.index;
    Reply reply;
    GoodbyeReason reason{};
    const Bytes answer =
        bench.server->receive(datagrams.pack(sample), bench.hand_peer, bench.now, bench.room);
    EXPECT_EQ(datagrams.take(answer, reply, reason), DatagramSession::Arrival::reply);
    return datagrams.view()->robot;
  };
  const int first = look()->seat;
  for (int i = 1; i < 6; ++i) EXPECT_EQ(look()->seat, (first + i) % 2);
  bench.server->answer(control::LeaveRequest{TwoRobots::kRobot}, 0, {}, bench.now);
  for (int i = 0; i < 3; ++i) {
    const auto seen = look();
    ASSERT_TRUE(seen);
    EXPECT_EQ(seen->seat, 1);
    EXPECT_EQ(seen->seats, 2) << "the first seat is empty";
  }
}

}  // namespace
}  // namespace feltwire::switching_leader_test

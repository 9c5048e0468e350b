// Tests several hands and a robot. The link selects the leader, and a hand-over must never move the
// robot.

#include <gtest/gtest.h>

#include <random>
#include <vector>

#include "tests/server/scene/teleop_link_bench.hpp"

namespace feltwire::teleop_link_test {
namespace {

using enum LinkState;

TEST(TeleopLink, AHandThatReleasesHandsOverWithoutAStep) {
  Bench bench;
  bench.press(bench.anna);
  bench.anna.at.x() += 1e-4;
  bench.send(bench.anna);
  ASSERT_EQ(bench.told(bench.anna), engaged);
  const Vec3 robot = bench.state.commanded.position;
  EXPECT_NEAR(robot.x(), 0.4001, 1e-12);
  bench.send(bench.ben);  // Ben has released.
  bench.anna.pressed = false;
  bench.send(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), clutched);
  bench.ben.pressed = true;
  bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.told(bench.anna), disabled);
  EXPECT_EQ(bench.target.pose.position, robot) << "exactly";
  bench.ben.at.y() -= 1e-4;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.pose.position.y(), robot.y() - 1e-4, 1e-12);
}

TEST(TeleopLink, NobodyTakesTheLeadFromAHandThatPresses) {
  Bench bench;
  bench.press(bench.anna);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.anna), engaged);
  EXPECT_EQ(bench.told(bench.ben), disabled);
  // A switch that was pressed too early, or is taped down, must have no later effect.
  bench.anna.pressed = false;
  bench.send(bench.anna);
  for (int n = 0; n < 50; ++n) bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), disabled);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  // The lead then returns to the first hand.
  bench.send(bench.anna);
  bench.ben.pressed = false;
  bench.send(bench.ben);
  bench.anna.pressed = true;
  bench.send(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), engaged);
}

TEST(TeleopLink, AHandThatFellSilentKeepsNobodyWaiting) {
  Bench bench;
  bench.press(bench.anna);
  bench.send(bench.ben);
  bench.ben.pressed = true;
  bench.now += TeleopLink::kSilence;
  bench.send(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  bench.send(bench.anna);  // The hand returns with its switch still pressed.
  EXPECT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.told(bench.anna), disabled);
}

TEST(TeleopLink, AHandOverPaysNothing) {
  Bench bench;
  bench.press(bench.anna);
  bench.anna.work = 0.25;
  bench.send(bench.anna);
  const double paid = bench.target.hand_work;
  bench.anna.pressed = false;
  bench.send(bench.anna);
  bench.ben.work = 1e6;
  bench.press(bench.ben);
  ASSERT_EQ(bench.told(bench.ben), engaged);
  EXPECT_EQ(bench.target.hand_work, paid);
  bench.ben.work += 0.5;
  bench.send(bench.ben);
  EXPECT_NEAR(bench.target.hand_work, paid + 0.5, 1e-9);
}

TEST(TeleopLink, AHandThatLeavesMakesRoom) {
  Bench bench;
  bench.press(bench.anna);
  bench.send(bench.ben);
  bench.link.leave(bench.anna.number);
  bench.press(bench.ben);
  EXPECT_EQ(bench.told(bench.ben), engaged);
  std::vector<Hand> crowd;
  for (std::uint32_t n = 0; n < 2 * TeleopLink::kMostWaiting; ++n)
    crowd.push_back({100 + n, Vec3::Zero()});
  for (Hand& hand : crowd) bench.send(hand);
  for (const Hand& hand : crowd) bench.link.leave(hand.number);
  bench.ben.pressed = false;
  bench.send(bench.ben);
  bench.press(bench.anna);
  EXPECT_EQ(bench.told(bench.anna), engaged) << "those that left wait no more";
}

RemoteSeat aligned_seat(double gate) {
  RemoteSeat seat;
  seat.aligned = Alignment{Quaternion(Eigen::AngleAxisd(1.0, Vec3(1.0, 2.0, 2.0) / 3.0)), gate};
  return seat;
}

TEST(TeleopLink, AHandTurnsToTheRobotBeforeItEngages) {
  const RemoteSeat seat = aligned_seat(0.2);
  Bench bench(seat);
  const Quaternion robot = bench.state.commanded.orientation =
      Quaternion(Eigen::AngleAxisd(0.7, Vec3::UnitY()));
  const Quaternion there = robot * seat.aligned->offset.conjugate();  // the aligned orientation
  Hand& anna = bench.anna;
  const auto missing = [&] { return bench.link.reply_for(anna.number, bench.now).turn; };
  anna.turn = turned(there, Vec3(0.0, 0.0, 0.5));
  bench.press(anna);
  EXPECT_EQ(bench.told(anna), aligning);
  EXPECT_EQ(bench.link.state(), aligning);
  ASSERT_TRUE(missing());
  EXPECT_NEAR((*missing() + Vec3(0.0, 0.0, 0.5)).norm(), 0.0, 1e-9) << "back by 0.5 rad";
  anna.turn = turned(there, Vec3(0.0, 0.0, 0.19));
  bench.send(anna);
  EXPECT_EQ(bench.told(anna), aligning) << "the switch was pressed outside of the gate";
  anna.pressed = false;
  bench.send(anna);
  EXPECT_EQ(bench.told(anna), ready);
  anna.pressed = true;
  bench.send(anna);
  ASSERT_EQ(bench.told(anna), engaged);
  EXPECT_FALSE(missing());
  EXPECT_LE(rotation_between(bench.target.pose.orientation, robot).norm(), 1e-12);
  EXPECT_EQ(bench.target.pose.position, Vec3(0.4, 0.1, 0.3)) << "exactly";
  // A rotating hand must move the robot to the hand's orientation.
  for (int i = 0; i < 500; ++i) {
    anna.turn = turned(anna.turn, Vec3(0.0, 1e-3, 0.0));
    bench.send(anna);
  }
  EXPECT_LE(
      rotation_between(bench.target.pose.orientation, anna.turn * seat.aligned->offset).norm(),
      1e-9);
  // The hand releases, rotates away and must align again.
  anna.pressed = false;
  bench.send(anna);
  EXPECT_EQ(bench.told(anna), clutched);
  anna.turn = turned(anna.turn, Vec3(0.3, 0.0, 0.0));
  bench.press(anna);
  EXPECT_EQ(bench.told(anna), aligning);
}

/// Hands rotate and press at random. No hand may engage outside of the gate. No target may rotate
/// more than 1.5 times as far as its hand, or step at an engagement.
TEST(TeleopLink, NoEngagementOfAnAlignedHandTurnsTheRobot) {
  std::mt19937_64 random(6);
  std::uniform_real_distribution<double> any(-1.0, 1.0);
  const RemoteSeat seat = aligned_seat(0.3);
  Bench bench(seat);
  int engagements = 0, refused = 0;
  for (int n = 0; n < 30000; ++n) {
    Hand& hand = random() % 2 == 0 ? bench.anna : bench.ben;
    if (random() % 16 == 0) hand.pressed = !hand.pressed;
    const double step = random() % 500 == 0 ? 0.5 : 2e-3;
    const Quaternion had = hand.turn;
    hand.turn = turned(had, step * Vec3(any(random), any(random), any(random)));
    const LinkState before = bench.told(hand);
    const Quaternion robot = bench.state.commanded.orientation;
    bench.send(hand);
    const double moved = rotation_between(robot, bench.state.commanded.orientation).norm();
    const bool leads = bench.told(hand) == engaged;
    refused += bench.told(hand) == aligning ? 1 : 0;
    if (leads && before != engaged) {
      ++engagements;
      ASSERT_LE(moved, 1e-12);
      ASSERT_LE(seat.aligned->missing(hand.turn, robot).norm(), seat.aligned->gate);
    }
    ASSERT_LE(moved, leads ? 1.5 * rotation_between(had, hand.turn).norm() + 1e-12 : 0.0);
    if (n % 1000 == 0)  // aligns the hand again
      hand.turn = bench.state.commanded.orientation * seat.aligned->offset.conjugate();
  }
  EXPECT_GT(engagements, 100);
  EXPECT_GT(refused, 100);
}

/// Hands press at random from any position. The target must stay when another hand begins to lead.
TEST(TeleopLink, NoHandOverOfManyMovesTheRobot) {
  std::mt19937_64 random(5);
  std::uniform_real_distribution<double> any(-10.0, 10.0);
  Bench bench;
  std::vector<Hand> hands;
  for (std::uint32_t n = 1; n <= 6; ++n)
    hands.push_back({n, Vec3(any(random), any(random), any(random))});
  std::uint32_t leads = 0;
  int handed_over = 0;
  for (int n = 0; n < 20000; ++n) {
    Hand& hand = hands[random() % hands.size()];
    if (random() % 8 == 0) hand.pressed = !hand.pressed;
    hand.at += 1e-5 * Vec3(any(random), any(random), any(random));
    const Vec3 before = bench.state.commanded.position;
    bench.send(hand);
    int leading = 0;
    for (const Hand& one : hands) leading += bench.told(one) == engaged ? 1 : 0;
    ASSERT_LE(leading, 1);
    if (bench.told(hand) == engaged && leads != hand.number) {
      ASSERT_EQ(bench.target.pose.position, before) << n;
      leads = hand.number;
      ++handed_over;
    }
  }
  EXPECT_GT(handed_over, 100);
}

/// A hand must get all surfaces at its own contact position, along its free axes.
TEST(TeleopLink, TellsTheSurfacesBesideTheContact) {
  RemoteSeat seat;
  seat.scale = 2.0;
  seat.workspace.locked = {false, true, false};
  Bench bench(seat);
  bench.press(bench.anna);
  const Vec3 robot = bench.state.commanded.position;
  const auto surface = [&](std::uint32_t number, const Vec3& normal) {
    return RemoteContact{
        .surface = number, .point = robot - 0.01 * normal, .normal = normal, .stiffness = 700.0};
  };
  OtherSurfaces& others = bench.state.others;
  others.count = 2;
  bench.state.contact = surface(3, Vec3::UnitZ());
  others.surfaces = {surface(1, Vec3::UnitX()), surface(2, Vec3::UnitY())};
  bench.say();
  const Remote told = bench.link.reply_for(bench.anna.number, bench.now);
  EXPECT_EQ(told.contact.surface, 3u);
  ASSERT_EQ(told.others.count, 1) << "nothing is told along a locked axis";
  const RemoteContact& other = told.others.surfaces[0];
  EXPECT_EQ(other.surface, 1u);
  EXPECT_NEAR((bench.anna.at - other.point).dot(other.normal), 0.005, 1e-12);
  EXPECT_EQ(other.stiffness, 1400.0);
  bench.anna.pressed = false;
  bench.send(bench.anna);
  EXPECT_EQ(bench.link.reply_for(bench.anna.number, bench.now).others.count, 0) << "not engaged";
}

}  // namespace
}  // namespace feltwire::teleop_link_test

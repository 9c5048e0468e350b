// A hand leads a robot over sealed datagrams and an emulated link. Tests the force of a wall that
// is not in the server's scene, and the reaction to each fault.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "tests/client/simulated_robots/teleoperation_bench.hpp"

namespace feltwire::teleoperation_test {
namespace {

using test::Teleoperation;
using enum LinkState;

// The robot's spring of 1000 N/m and the wall's of 2000 N/m, in series.
constexpr double kSeries = 1000.0 * 2000.0 / 3000.0;

TEST(Teleoperation, TheRobotFollowsTheHandFromWhereItIs) {
  Teleoperation bench;
  bench.run(0.2);
  EXPECT_EQ(bench.state(), ready);
  const Vec3 robot = bench.robot.position(), hand = bench.hand.true_position();
  bench.engage();
  EXPECT_EQ(bench.state(), engaged);
  EXPECT_LE((bench.robot.position() - robot).norm(), 1e-4) << "nothing moved yet";
  bench.move(Vec3(0.03, 0.02, 0.01), 1.0);
  bench.run(0.5);
  const Vec3 moved = bench.hand.true_position() - hand;
  EXPECT_GE(moved.norm(), 0.03);
  EXPECT_LE((bench.robot.position() - robot - moved).norm(), 1e-4);
  EXPECT_EQ(bench.servo.held().force().norm(), 0.0) << "the air is free";
}

/// The hand first rotates as the server requests. Then the robot must rotate with the hand, with
/// any offset between them.
TEST(Teleoperation, AnAlignedHandTurnsTheRobotAsItIsTurned) {
  RemoteSeat seat;
  seat.aligned = Alignment{Quaternion(Eigen::AngleAxisd(0.8, Vec3::UnitX())), 0.2};
  Teleoperation bench("delay=25,loss=2", seat);
  const auto robot_turn = [&] { return bench.commanded.orientation; };
  const auto missing = [&] { return bench.servo.remote()->remote().turn; };
  bench.run(0.3);
  EXPECT_EQ(bench.state(), aligning);
  ASSERT_TRUE(missing());
  EXPECT_NEAR(missing()->norm(), 0.8, 1e-6);
  bench.engage();
  EXPECT_EQ(bench.state(), aligning) << "it is turned away";
  EXPECT_EQ(bench.servo.remote()->remote().state, aligning);

  bench.hand.turn = turned(bench.hand.turn, 0.8 * *missing());  // 0.16 rad remain.
  bench.engage();
  ASSERT_EQ(bench.state(), engaged);
  EXPECT_LE(rotation_between(Quaternion::Identity(), robot_turn()).norm(), 1e-9) << "no step";
  for (int i = 0; i < 600; ++i) {
    bench.hand.turn = turned(bench.hand.turn, Vec3(0.0, 0.0, 1e-3));
    bench.tick();
  }
  bench.run(0.5);
  EXPECT_LE(rotation_between(robot_turn(), bench.hand.turn * seat.aligned->offset).norm(), 1e-6);
  EXPECT_EQ(bench.servo.held().force().norm(), 0.0);
}

/// The ratio of displayed to series stiffness, for a press of 25 mm into the wall. The press begins
/// 20 mm in front of the wall.
struct Pressed {
  double displayed = 0.0, swing = 0.0, robot_force = 0.0, hand_force = 0.0;
};
Pressed press(Teleoperation& bench, double force_scale = 1.0) {
  bench.move(Vec3(0.0, 0.0, -0.045), 0.6);
  bench.run(1.4);
  double low = 1e9, high = -1e9;
  for (int i = 0; i < 500; ++i) {
    bench.tick();
    low = std::min(low, bench.hand.true_position().z());
    high = std::max(high, bench.hand.true_position().z());
  }
  const Lead lead = *bench.servo.lead();
  const RemoteContact& contact = bench.servo.remote()->remote().contact;
  const double surface = contact.point.z() + lead.offset.z();
  const double depth = surface - bench.hand.true_position().z();
  return {bench.force() / depth / (force_scale * kSeries), high - low, bench.robot.force().z(),
          bench.force()};
}

TEST(Teleoperation, AWallThatTheServerDoesNotKnowIsFelt) {
  Teleoperation bench;
  bench.engage();
  const Pressed pressed = press(bench);
  EXPECT_NEAR(pressed.displayed, 1.0, 0.05);
  EXPECT_GE(pressed.hand_force, 3.0);
  EXPECT_NEAR(pressed.hand_force, pressed.robot_force, 0.1 * pressed.robot_force);
  EXPECT_LE(pressed.swing, 50e-6);
  EXPECT_LE(bench.made(), 0.0);
}

TEST(Teleoperation, TheHandsForceMayBeScaled) {
  for (const double scale : {0.25, 0.5, 3.0}) {
    for (const char* link : {"delay=0", "delay=25,loss=2,seed=3"}) {
      SCOPED_TRACE(std::string(link) + ", force_scale " + std::to_string(scale));
      Teleoperation bench(link, {.force_scale = scale});
      bench.engage();
      const Pressed pressed = press(bench, scale);
      EXPECT_NEAR(pressed.displayed, 1.0, 0.05);
      EXPECT_GE(pressed.hand_force, 0.5);
      EXPECT_NEAR(pressed.hand_force, scale * pressed.robot_force,
                  0.1 * scale * pressed.robot_force);
      EXPECT_LE(pressed.swing, 50e-6);
      EXPECT_LE(bench.made(), 0.0);
    }
  }
}

TEST(Teleoperation, IsFeltOverADelayAndLoss) {
  Teleoperation bench("delay=25,loss=2,seed=3");  // two links with a round trip of 100 ms
  bench.engage();
  const Pressed first = press(bench);
  EXPECT_NEAR(first.displayed, 1.0, 0.05);
  EXPECT_GE(first.hand_force, 1.0);
  EXPECT_LE(first.swing, 50e-6);
  bench.move(Vec3(0.0, 0.0, 0.045), 0.6);
  bench.run(0.5);
  EXPECT_EQ(bench.force(), 0.0);
  const Pressed second = press(bench);
  EXPECT_NEAR(second.displayed, 1.0, 0.05);
  EXPECT_LE(bench.made(), 0.0);
  EXPECT_LE(bench.follower.statistics().largest_force, 25.0);
}

}  // namespace
}  // namespace feltwire::teleoperation_test

// Tests the engagement of a robot's leader: the switch, the clutch offset and the motion limits.

#include "core/teleoperation/lead_engagement.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>
#include <vector>

#include "core/teleoperation/clutch_offset.hpp"
#include "core/teleoperation/motion_limit.hpp"
#include "tests/core/support.hpp"

namespace feltwire::lead_engagement_test {
namespace {

using namespace test;
using enum LinkState;

constexpr LinkInputs kReleased{.seated = true, .robot_well = true};
constexpr LinkInputs kPressed{.seated = true, .robot_well = true, .deadman = true};

LinkInputs with(LinkInputs in, bool LinkInputs::*what, bool value = true) {
  in.*what = value;
  return in;
}

/// Returns an engagement in the engaged state.
LeadEngagement engaged_one() {
  LeadEngagement engagement;
  engagement.step(kReleased);
  EXPECT_EQ(engagement.step(kPressed), engaged);
  return engagement;
}

TEST(LeadEngagement, EngagesAndClutches) {
  LeadEngagement engagement;
  EXPECT_EQ(engagement.state(), disabled);
  EXPECT_EQ(engagement.step({}), disabled);
  EXPECT_EQ(engagement.step(kReleased), ready);
  EXPECT_EQ(engagement.step(kPressed), engaged);
  EXPECT_EQ(engagement.step(kReleased), clutched);
  EXPECT_EQ(engagement.step(kPressed), engaged);
}

TEST(LeadEngagement, ATapedSwitchNeverEngages) {
  LeadEngagement engagement;
  for (int i = 0; i < 10; ++i) EXPECT_EQ(engagement.step(kPressed), disabled);
  EXPECT_EQ(engagement.step(kReleased), ready);
  EXPECT_EQ(engagement.step(kPressed), engaged);
}

TEST(LeadEngagement, WhatBreaksTheLinkDemandsAReleasedSwitch) {
  const struct {
    LinkInputs in;
    LinkState state;
  } breaks[] = {{with(kPressed, &LinkInputs::seated, false), disabled},
                {with(kPressed, &LinkInputs::robot_well, false), fault},
                {with(kPressed, &LinkInputs::hand_silent), hold},
                {with(kPressed, &LinkInputs::refused), hold},
                {with(kPressed, &LinkInputs::wrench_above), hold}};
  for (const auto& broken : breaks) {
    SCOPED_TRACE(name(broken.state));
    LeadEngagement engagement = engaged_one();
    EXPECT_EQ(engagement.step(broken.in), broken.state);
    EXPECT_EQ(engagement.step(kPressed), broken.state)
        << "all is well again, the switch is pressed";
    EXPECT_EQ(engagement.step(kReleased), ready);
    EXPECT_EQ(engagement.step(kPressed), engaged);
  }
}

TEST(LeadEngagement, AHandLeadsTheRobotOutOfAWrenchThatIsAbove) {
  LeadEngagement engagement = engaged_one();
  const LinkInputs above = with(kPressed, &LinkInputs::wrench_above);
  EXPECT_EQ(engagement.step(above), hold);
  EXPECT_EQ(engagement.step(with(kReleased, &LinkInputs::wrench_above)), ready);
  EXPECT_EQ(engagement.step(above), engaged) << "else it could never be led out";
  EXPECT_EQ(engagement.step(above), engaged);
  EXPECT_EQ(engagement.step(kPressed), engaged);
  EXPECT_EQ(engagement.step(above), hold) << "it rose again";
}

TEST(LeadEngagement, AHandThatIsNotAlignedDoesNotEngage) {
  const LinkInputs turned_away = with(kReleased, &LinkInputs::aligned, false);
  const LinkInputs pressed_away = with(kPressed, &LinkInputs::aligned, false);
  LeadEngagement engagement;
  EXPECT_EQ(engagement.step(turned_away), aligning);
  EXPECT_EQ(engagement.step(pressed_away), aligning);
  EXPECT_EQ(engagement.step(kPressed), aligning) << "pressed before it was aligned";
  EXPECT_EQ(engagement.step(kReleased), ready);
  EXPECT_EQ(engagement.step(pressed_away), aligning);
  EXPECT_EQ(engagement.step(turned_away), aligning);
  EXPECT_EQ(engagement.step(kReleased), ready);
  EXPECT_EQ(engagement.step(kPressed), engaged);
  EXPECT_EQ(engagement.step(pressed_away), engaged) << "now the robot turns with it";
  EXPECT_EQ(engagement.step(turned_away), aligning);
  EXPECT_EQ(engagement.step(with(turned_away, &LinkInputs::hand_silent)), hold);
  EXPECT_EQ(engagement.step(pressed_away), hold);
  EXPECT_EQ(engagement.step(with(turned_away, &LinkInputs::robot_well, false)), fault);
}

/// Tests any inputs in any order. The robot must move only while the newest sample's switch is
/// pressed and no fault is present. After a fault, the user must release the switch first. The
/// motion must begin only while the hand is aligned.
TEST(LeadEngagement, MovesNothingUnlessItMay) {
  Random random(41);
  LeadEngagement engagement;
  bool armed = false;
  int engagements = 0;
  for (int i = 0; i < 200000; ++i) {
    const LinkInputs in{.seated = random.chance(0.99),
                        .robot_well = random.chance(0.99),
                        .hand_silent = random.chance(0.01),
                        .refused = random.chance(0.01),
                        .deadman = random.chance(0.7),
                        .wrench_above = random.chance(0.01),
                        .aligned = random.chance(0.8)};
    const LinkState before = engagement.state();
    const LinkState state = engagement.step(in);
    const bool sound = in.seated && in.robot_well && !in.hand_silent;
    if (!sound || state == hold || (state == aligning && in.deadman)) armed = false;
    if (sound && !in.deadman && state != hold) armed = true;
    if (state == engaged) {
      ++engagements;
      ASSERT_TRUE(sound && in.deadman && armed);
      ASSERT_TRUE(in.aligned || before == engaged);
    }
  }
  EXPECT_GT(engagements, 10000);
}

Pose any_pose(Random& random) {
  const double angle = random.uniform(0.0, std::numbers::pi);
  return {random.uniform(0.0, 500.0) * random.direction(),
          Quaternion(Eigen::AngleAxisd(angle, random.direction()))};
}

TEST(ClutchOffset, TheFirstStepIsZero) {
  Random random(42);
  for (int i = 0; i < 1000; ++i) {
    ClutchOffset index(std::pow(10.0, random.uniform(-2.0, 2.0)));
    const Pose hand = any_pose(random), robot = any_pose(random);
    index.engage(hand, robot);
    const Pose target = index.target(hand);
    ASSERT_EQ(target.position, robot.position);
    ASSERT_LE(rotation_between(target.orientation, robot.orientation).norm(), 1e-14);
  }
}

TEST(ClutchOffset, ScalesMovementAndKeepsPower) {
  Random random(43);
  constexpr double kScale = 0.25;
  ClutchOffset index(kScale);
  const Pose hand = any_pose(random), robot = any_pose(random);
  index.engage(hand, robot);
  Pose there = hand;
  there.position += Vec3(0.0, 0.04, 0.0);
  there.orientation = Quaternion(Eigen::AngleAxisd(0.3, Vec3::UnitZ())) * hand.orientation;
  const Pose target = index.target(there);
  EXPECT_TRUE(target.position.isApprox(robot.position + Vec3(0.0, 0.01, 0.0)));
  EXPECT_NEAR(
      (rotation_between(robot.orientation, target.orientation) - 0.3 * Vec3::UnitZ()).norm(), 0.0,
      1e-12);

  // The hand must meet a surface when the target meets it.
  RemoteContact contact{.surface = 1, .point = target.position, .stiffness = 800.0};
  contact.velocity = Vec3(0.01, 0.0, 0.0);
  const RemoteContact seen = index.at_hand(contact);
  EXPECT_NEAR((seen.point - there.position).norm(), 0.0, 1e-12);
  // The force is equal over a depth that is 1 / s of the robot's. The power is therefore equal too.
  const double depth = 0.01;
  EXPECT_DOUBLE_EQ(seen.stiffness * depth / kScale, contact.stiffness * depth);
  EXPECT_DOUBLE_EQ(index.at_robot(1.0), kScale);
  EXPECT_DOUBLE_EQ(index.at_hand(EnergyCounters{kScale, 0.0, 0.0}).given, 1.0);
}

TEST(ClutchOffset, ScalesForcesAndKeepsPower) {
  constexpr double kScale = 0.25, kForceScale = 3.0;
  ClutchOffset index(kScale, kForceScale);
  index.engage({}, {});
  const RemoteContact contact{.surface = 1, .stiffness = 800.0};
  const double depth = 0.01;                       // [m] at the robot
  const double force = contact.stiffness * depth;  // [N] on the robot
  const double at_hand = index.at_hand(contact).stiffness * depth / kScale;
  EXPECT_DOUBLE_EQ(at_hand, kForceScale * force);
  // The spring's energy at the robot, in the hand's scale, and back.
  const double held = 0.5 * force * depth, seen = 0.5 * at_hand * depth / kScale;
  EXPECT_DOUBLE_EQ(index.at_hand(EnergyCounters{held, held, held}).given, seen);
  EXPECT_DOUBLE_EQ(index.at_hand(EnergyCounters{held, held, held}).pushed, seen);
  EXPECT_DOUBLE_EQ(index.at_robot(seen), held);
}

struct Largest {
  double speed = 0.0, acceleration = 0.0, jerk = 0.0;
};

TEST(MotionLimit, KeepsItsLimitsForWhateverIsWanted) {
  Random random(44);
  constexpr double kPeriod = 1e-3;
  const MotionLimits limits;
  MotionLimit motion(limits);
  motion.begin({});
  Pose wanted;
  Largest most;
  Vec3 before = Vec3::Zero(), velocity = Vec3::Zero(), acceleration = Vec3::Zero();
  for (int i = 0; i < 50000; ++i) {
    if (random.chance(0.005)) wanted.position = random.uniform(0.0, 0.2) * random.direction();
    if (random.chance(0.3)) wanted.position += random.uniform(0.0, 2e-3) * random.direction();
    if (random.chance(0.001)) wanted.position.x() = std::nan("");
    const Vec3 here = random.chance(0.01) ? motion.stop(kPeriod).position
                                          : motion.follow(wanted, kPeriod).position;
    const Vec3 v = (here - before) / kPeriod;
    const Vec3 a = (v - velocity) / kPeriod;
    most.speed = std::max(most.speed, v.norm());
    most.acceleration = std::max(most.acceleration, a.norm());
    most.jerk = std::max(most.jerk, (a - acceleration).norm() / kPeriod);
    before = here, velocity = v, acceleration = a;
  }
  EXPECT_LE(most.speed, limits.speed * (1.0 + 1e-9));
  EXPECT_LE(most.acceleration, limits.acceleration * (1.0 + 1e-6));
  EXPECT_LE(most.jerk, limits.jerk * 1.01);
  EXPECT_GT(most.speed, 0.85 * limits.speed);
}

TEST(MotionLimit, ArrivesAndStands) {
  constexpr double kPeriod = 1e-3;
  const MotionLimits limits;
  for (const double way : {1e-5, 1e-3, 0.02, 0.3}) {
    MotionLimit motion(limits);
    motion.begin({});
    Pose wanted;
    wanted.position.x() = way;
    double farthest = 0.0;
    const int needed = static_cast<int>((way / limits.speed + 1.0) / kPeriod);
    for (int i = 0; i < needed; ++i)
      farthest = std::max(farthest, motion.follow(wanted, kPeriod).position.x());
    EXPECT_NEAR(motion.here().position.x(), way, 1e-6) << way;
    EXPECT_LE(farthest - way, std::max(1e-6, 0.01 * way)) << way;
    EXPECT_LE(motion.velocity().norm(), 1e-4) << way;
  }
}

TEST(MotionLimit, StopsWithinItsWay) {
  constexpr double kPeriod = 1e-3;
  const MotionLimits limits;
  MotionLimit motion(limits);
  motion.begin({});
  Pose wanted;
  wanted.position.x() = 10.0;
  for (int i = 0; i < 1000; ++i) motion.follow(wanted, kPeriod);
  const double from = motion.here().position.x();
  for (int i = 0; i < 200; ++i) motion.stop(kPeriod);
  const double way = motion.here().position.x() - from;
  const double ramp = limits.acceleration / limits.jerk;
  EXPECT_GE(way, 0.0);
  EXPECT_LE(way,
            limits.speed * limits.speed / (2.0 * limits.acceleration) + 2.0 * limits.speed * ramp);
  EXPECT_LE(motion.velocity().norm(), 1e-6);
}

TEST(MotionLimit, FollowsASlowHandClosely) {
  constexpr double kPeriod = 1e-3;
  const MotionLimits limits;
  MotionLimit motion(limits);
  motion.begin({});
  double farthest = 0.0;
  for (int i = 0; i < 4000; ++i) {
    Pose wanted;  // 20 mm at 0.5 Hz: 0.063 m/s
    wanted.position.y() = 0.02 * std::sin(std::numbers::pi * kPeriod * i);
    motion.follow(wanted, kPeriod);
    farthest = std::max(farthest, (motion.here().position - wanted.position).norm());
  }
  EXPECT_LE(farthest, 4e-3);
}

TEST(MotionLimit, TurnsNoFasterThanItMay) {
  const MotionLimits limits;
  MotionLimit motion(limits);
  motion.begin({});
  Pose wanted;
  wanted.orientation = Quaternion(Eigen::AngleAxisd(1.0, Vec3::UnitY()));
  Quaternion before = Quaternion::Identity();
  for (int i = 0; i < 1100; ++i) {
    const Quaternion now = motion.follow(wanted, 1e-3).orientation;
    ASSERT_LE(rotation_between(before, now).norm(), limits.turning * 1e-3 * (1.0 + 1e-9));
    before = now;
  }
  EXPECT_LE(rotation_between(before, wanted.orientation).norm(), 1e-9);
}

}  // namespace
}  // namespace feltwire::lead_engagement_test

// A robot's tool must rotate with the hand. Tests the gate at the engagement, and how the remaining
// offset shrinks.

#include "core/teleoperation/alignment.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/teleoperation/clutch_offset.hpp"
#include "tests/core/support.hpp"

namespace feltwire::alignment_test {
namespace {

using test::Random;

Quaternion any_turn(Random& random) {
  return Quaternion(Eigen::AngleAxisd(random.uniform(0.0, std::numbers::pi), random.direction()));
}
double angle_between(const Quaternion& a, const Quaternion& b) {
  return rotation_between(a, b).norm();
}

TEST(Alignment, AHandThatTurnsByWhatIsMissingIsAligned) {
  Random random(71);
  for (int i = 0; i < 1000; ++i) {
    const Alignment aligned{any_turn(random), 0.2};
    const Quaternion hand = any_turn(random), robot = any_turn(random);
    const Vec3 missing = aligned.missing(hand, robot);
    ASSERT_LE(missing.norm(), std::numbers::pi + 1e-9);
    const Quaternion there = turned(hand, missing);
    ASSERT_LE(angle_between(there * aligned.offset, robot), 1e-9);
    ASSERT_LE(aligned.missing(there, robot).norm(), 1e-9);
  }
}

/// The test covers any engagement within the gate. The first target must be the robot's pose. No
/// target may rotate by more than 1.5 times the hand's rotation. The offset must only shrink, down
/// to zero.
TEST(Alignment, WhatIsLeftIsGivenBackWhileTheHandTurns) {
  Random random(72);
  for (int run = 0; run < 200; ++run) {
    const Alignment aligned{any_turn(random), 0.3};
    Pose hand{Vec3::Zero(), any_turn(random)};
    const Pose robot{Vec3(0.1, 0.2, 0.3),
                     turned(hand.orientation * aligned.offset,
                            random.uniform(0.0, aligned.gate) * random.direction())};
    ClutchOffset index(1.0);
    index.engage(hand, robot);
    index.align(aligned.offset, 0.0);
    Pose target = index.target(hand);
    ASSERT_EQ(target.position, robot.position);
    ASSERT_LE(angle_between(target.orientation, robot.orientation), 1e-14);
    double left = aligned.missing(hand.orientation, target.orientation).norm(), turned_by = 0.0;
    ASSERT_LE(left, aligned.gate + 1e-9);
    const double first = left;
    while (turned_by < 2.1 * first) {
      const double step = random.uniform(0.0, 0.02);
      turned_by += step;
      hand.orientation = turned(hand.orientation, step * random.direction());
      index.align(aligned.offset, Alignment::kGivenBack * step);
      const Pose next = index.target(hand);
      ASSERT_LE(angle_between(target.orientation, next.orientation),
                (1.0 + Alignment::kGivenBack) * step + 1e-12);
      const double now = aligned.missing(hand.orientation, next.orientation).norm();
      ASSERT_NEAR(now, std::max(0.0, first - Alignment::kGivenBack * turned_by), 1e-9);
      target = next;
      left = now;
    }
    ASSERT_LE(left, 1e-9);
  }
}

TEST(Alignment, AHandThatStandsTurnsNothing) {
  ClutchOffset index(1.0);
  const Pose hand{Vec3::Zero(), Quaternion(Eigen::AngleAxisd(0.2, Vec3::UnitX()))};
  index.engage(hand, Pose{});
  for (int i = 0; i < 100; ++i) index.align(Quaternion::Identity(), 0.0);
  EXPECT_LE(angle_between(index.target(hand).orientation, Quaternion::Identity()), 1e-14);
}

}  // namespace
}  // namespace feltwire::alignment_test

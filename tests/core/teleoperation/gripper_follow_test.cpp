// A robot's gripper follows the lever in the hand.

#include "core/teleoperation/gripper_follow.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

namespace feltwire::gripper_follow_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
constexpr double kWidest = 0.08;  // [m]

GripperFollow engaged_at(double opening) {
  GripperFollow gripper({}, kWidest);
  gripper.begin(opening);
  gripper.engage();
  return gripper;
}

TEST(GripperFollow, CatchesUpSlowlyAndFollowsFast) {
  const GripperLimits limits;
  GripperFollow gripper = engaged_at(0.03);
  double before = 0.03;
  int slow = 0;
  while (before < 0.07) {
    const double now = gripper.step(0.07, kPeriod);
    ASSERT_LE(now - before, limits.catch_up * kPeriod * (1.0 + 1e-9));
    before = now;
    ++slow;
  }
  EXPECT_NEAR(slow * kPeriod, 0.04 / limits.catch_up, 2.0 * kPeriod);
  for (int n = 1; n <= 100; ++n) {
    const double now = gripper.step(0.02, kPeriod);
    EXPECT_NEAR(now, 0.07 - n * limits.speed * kPeriod, 1e-9);
  }
  // After the next engagement, the gripper must catch up again.
  gripper.engage();
  EXPECT_NEAR(gripper.step(0.0, kPeriod), 0.05 - limits.catch_up * kPeriod, 1e-9);
}

TEST(GripperFollow, IsCaughtByALeverThatPassesIt) {
  const GripperLimits limits;
  GripperFollow gripper = engaged_at(0.04);
  double opening = 0.04;
  for (int n = 0; n <= 225; ++n) opening = gripper.step(n * limits.speed * kPeriod, kPeriod);
  EXPECT_NEAR(opening, 0.045, 2.0 * limits.speed * kPeriod);
}

TEST(GripperFollow, StaysWhereNothingIsSaidAndWithinItsRange) {
  GripperFollow gripper = engaged_at(0.03);
  for (const double none : {-1.0, -0.0001, std::nan(""), std::numeric_limits<double>::infinity()})
    EXPECT_EQ(gripper.step(none, kPeriod), 0.03);
  for (int n = 0; n < 5000; ++n) gripper.step(1e9, kPeriod);
  EXPECT_EQ(gripper.step(1e9, kPeriod), kWidest);
  GripperFollow none({}, 0.0);
  none.begin(0.0);
  EXPECT_EQ(none.step(0.05, 1.0), 0.0);
}

}  // namespace
}  // namespace feltwire::gripper_follow_test

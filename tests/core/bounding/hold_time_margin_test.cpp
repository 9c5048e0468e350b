#include "core/bounding/hold_time_margin.hpp"

#include <gtest/gtest.h>

#include <algorithm>

namespace feltwire::hold_time_margin_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]

TEST(HoldTimeMargin, IsThePeriodWhereTicksAreExact) {
  HoldTimeMargin reserve(kPeriod);
  for (int i = 0; i < 5000; ++i) {
    reserve.saw(i % 2 == 0 ? kPeriod : 0.2 * kPeriod, true);
    EXPECT_EQ(reserve.hold_time(), kPeriod);
    EXPECT_EQ(reserve.hold_time_of_any_hand(), kPeriod);
  }
}

TEST(HoldTimeMargin, ReckonsWithTheLatestOfTheLastSecondsAndAtMostOnePeriodMore) {
  HoldTimeMargin reserve(kPeriod);
  reserve.saw(1.1 * kPeriod, true);
  for (int i = 0; i < 900; ++i) reserve.saw(kPeriod, true);
  EXPECT_NEAR(reserve.hold_time(), 1.1 * kPeriod, 1e-15);
  EXPECT_NEAR(reserve.hold_time_of_any_hand(), 1.2 * kPeriod, 1e-15);
  for (int i = 0; i < 2400; ++i) reserve.saw(kPeriod, true);  // The margin forgets the late tick.
  EXPECT_EQ(reserve.hold_time(), kPeriod);
  EXPECT_EQ(reserve.hold_time_of_any_hand(), kPeriod);
  reserve.saw(0.7, true);
  for (int i = 0; i < 290; ++i) reserve.saw(kPeriod, true);
  EXPECT_NEAR(reserve.hold_time(), 2.0 * kPeriod, 1e-15);
  EXPECT_NEAR(reserve.hold_time_of_any_hand(), 2.0 * kPeriod, 1e-15);
}

/// Without a held force, or with a moving hand, the margin adapts at once to the need of any hand.
TEST(HoldTimeMargin, FollowsAtOnceWhereNoHandWouldFeelIt) {
  HoldTimeMargin reserve(kPeriod);
  reserve.saw(1.3 * kPeriod, false);
  EXPECT_NEAR(reserve.hold_time_of_any_hand(), 1.6 * kPeriod, 1e-15);
}

/// After a late tick, the reachable displacement alone may reduce the force. The hold time
/// therefore starts to grow at the following tick.
TEST(HoldTimeMargin, BeginsATickAfterTheLateOne) {
  HoldTimeMargin reserve(kPeriod);
  reserve.saw(1.3 * kPeriod, true);
  EXPECT_EQ(reserve.hold_time(), kPeriod);
  reserve.saw(0.7 * kPeriod, true);
  EXPECT_NEAR(reserve.hold_time(), 1.005 * kPeriod, 1e-15);
}

/// The need grows with h^2, or with h for an arbitrary hand. Its growth per tick must be below a
/// noticeable force step of 5 %.
TEST(HoldTimeMargin, FollowsLittleByLittle) {
  HoldTimeMargin reserve(kPeriod);
  double before = reserve.hold_time(), any_before = reserve.hold_time_of_any_hand();
  for (int i = 0; i < 6000; ++i) {
    reserve.saw(i % 2500 == 0 ? 1.7 * kPeriod : i == 3000 ? 0.3 : kPeriod, true);
    const double now = reserve.hold_time(), any_now = reserve.hold_time_of_any_hand();
    EXPECT_LT(now * now, 1.02 * before * before);
    EXPECT_GT(now * now, 0.99 * before * before);
    EXPECT_LT(any_now, 1.035 * any_before);
    EXPECT_GT(any_now, 0.99 * any_before);
    before = now;
    any_before = any_now;
  }
}

}  // namespace
}  // namespace feltwire::hold_time_margin_test

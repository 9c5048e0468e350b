// Tests Weber's fraction, and the lines that both ends extrapolate.

#include "protocol/session/deadband.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "tests/protocol/make.hpp"

namespace feltwire::deadband_test {
namespace {

constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

TEST(Deadband, IsAFractionOfTheValueAndAFloor) {
  const Vec3 ten(0, 6, 8);
  const Vec3 aside(1, 0, 0);  // Every direction counts equally.
  for (const Vec3& way : {ten.normalized().eval(), Vec3(-ten.normalized()), aside}) {
    EXPECT_FALSE(beyond_deadband(ten, ten - 1.0999 * way, 0.1, 0.1));
    EXPECT_TRUE(beyond_deadband(ten, ten - 1.1001 * way, 0.1, 0.1));
  }
  EXPECT_FALSE(beyond_deadband(ten, ten, 0.0, 0.0));
  EXPECT_TRUE(beyond_deadband(Vec3(kNan, 0, 0), ten, 0.5, 1.0));
  EXPECT_TRUE(beyond_deadband(ten, Vec3(0, 0, kNan), 0.5, 1.0));
  EXPECT_FALSE(beyond_deadband(Vec3(1e200, 0, 0), Vec3(1.05e200, 0, 0), 0.1, 0.0));
}

TEST(Deadband, OfACommandIsOfItsForceAndOfItsTorque) {
  const Command held{.elastic = Vec3(0, 0, 4), .frictional = Vec3(1, 0, 0)};
  // A different split of an equal force makes no difference.
  EXPECT_FALSE(
      beyond_deadband(held, {.elastic = Vec3(0.5, 0, 3.5), .frictional = Vec3(0.5, 0, 0.5)}, 0.01));
  EXPECT_TRUE(
      beyond_deadband(held, {.elastic = Vec3(0, 0, 4.5), .frictional = Vec3(1, 0, 0)}, 0.1));
  Command turned = held;
  turned.torque = Vec3(0, 0, 1.01 * kUnfeltTorque);
  EXPECT_TRUE(beyond_deadband(held, turned, 0.1));
}

TEST(Deadband, ContactBeginsAndEndsHoweverSoftly) {
  const Command least{.elastic = Vec3(0, 0, 1e-9)};
  EXPECT_TRUE(beyond_deadband(least, {}, 0.5));
  EXPECT_TRUE(beyond_deadband({}, least, 0.5));
  EXPECT_FALSE(beyond_deadband({}, {}, 0.0));
}

TEST(Extrapolation, IsALineThatTurnsNoPartRound) {
  const Command c{.elastic = Vec3(0, 0, 2), .frictional = Vec3(1, 0, 0), .torque = Vec3(0, 0.1, 0)};
  const Command rising{
      .elastic = Vec3(3, 0, 1), .frictional = Vec3(2, 0, 0), .torque = Vec3(0, 1, 0)};
  const Command later = extrapolated(c, rising, 0.1);
  EXPECT_TRUE(later.elastic.isApprox(Vec3(0.3, 0, 2.1), 1e-15));
  EXPECT_TRUE(later.frictional.isApprox(Vec3(1.2, 0, 0), 1e-15));
  EXPECT_TRUE(later.torque.isApprox(Vec3(0, 0.2, 0), 1e-15));

  // The elastic part falls to zero after 10 ms and stays zero. The other parts continue.
  const Command falling{.elastic = Vec3(0, 0, -200), .frictional = Vec3(2, 0, 0)};
  EXPECT_NEAR(extrapolated(c, falling, 0.009).elastic.z(), 0.2, 1e-12);
  EXPECT_NEAR(extrapolated(c, falling, 0.05).elastic.norm(), 0.0, 1e-12);
  EXPECT_NEAR(extrapolated(c, falling, 0.05).frictional.x(), 1.1, 1e-12);

  for (const double time : {0.0, -1.0, kNan}) EXPECT_EQ(extrapolated(c, falling, time), c);
  EXPECT_EQ(extrapolated(c, {.elastic = Vec3(0, kNan, 0)}, 0.1), c);
  EXPECT_EQ(extrapolated(c, {.elastic = Vec3(0, 1e308, 0)}, 1e9), c);
}

TEST(Extrapolation, APushNeverBecomesAPull) {
  test::Generator random(7);
  for (int i = 0; i < 20'000; ++i) {
    const Command c{test::vector(random, 5), test::vector(random, 5), test::vector(random, 1)};
    const Command rates{test::vector(random, 1e4), test::vector(random, 1e4),
                        test::vector(random, 1e4)};
    const Command later = extrapolated(c, rates, test::uniform(random, 0, 0.5));
    // The rounding limit is a hundred ulps of the products.
    const auto least = [](const Vec3& a, const Vec3& b) { return -1e-13 * a.norm() * b.norm(); };
    ASSERT_GE(c.elastic.dot(later.elastic), least(c.elastic, later.elastic));
    ASSERT_GE(c.frictional.dot(later.frictional), least(c.frictional, later.frictional));
    ASSERT_GE(c.torque.dot(later.torque), least(c.torque, later.torque));
  }
}

Command ramp(double time) {
  return {.elastic = Vec3(0, 0, 1 + 20 * time), .frictional = Vec3(3 - 4 * time, 0, 0)};
}

TEST(CommandTrend, FindsTheLineAtAnyRate) {
  for (const double period : {1e-4, 3e-4, 1e-3, 5e-3, 4e-2}) {
    CommandTrend trend;
    EXPECT_EQ(trend.rates(), Command{});
    for (int i = 0; i < 400; ++i) trend.add(ramp(i * period), period);
    EXPECT_NEAR(trend.rates().elastic.z(), 20, 1e-9) << period;
    EXPECT_NEAR(trend.rates().frictional.x(), -4, 1e-9) << period;
  }
}

/// Encoder noise of q at each end of a window W changes a slope by at most 2 q / W. A difference of
/// single samples would change it by 2 q / T.
TEST(CommandTrend, DividesTheEncodersNoiseByItsWindow) {
  test::Generator random(3);
  CommandTrend trend;
  const double quantum = 0.03, period = 1e-3, window = 0.01;
  double worst = 0.0;
  for (int i = 0; i < 5000; ++i) {
    Command c = ramp(i * period);
    c.elastic.z() += test::uniform(random, -quantum, quantum);
    trend.add(c, period);
    if (i > 20) worst = std::max(worst, std::abs(trend.rates().elastic.z() - 20));
  }
  EXPECT_LE(worst, 2 * quantum / (window - period));
  EXPECT_GT(worst, 1.0);
}

TEST(CommandTrend, ForgetsWhatWasBeforeContactBegan) {
  CommandTrend trend;
  const double period = 1e-3;
  for (int i = 0; i < 50; ++i) trend.add({}, period);
  EXPECT_EQ(trend.rates(), Command{});
  for (int i = 0; i < 4; ++i) trend.add(ramp(i * period), period);
  EXPECT_NEAR(trend.rates().elastic.z(), 20, 1e-9);  // The step to 1 N is excluded.
  trend.add({}, period);
  EXPECT_EQ(trend.rates(), Command{});
}

}  // namespace
}  // namespace feltwire::deadband_test

// Tests the account of a handle with a known largest speed.

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/bounding/account_samples.hpp"

namespace feltwire::account_speed_test {
namespace {

using namespace test;

constexpr double kPeriod = kSamplePeriod;

/// A force above 2 b v needs the energy f v T - b v^2 T. A smaller force needs the energy for a
/// hand of any speed.
TEST(Account, AHandOfKnownSpeedTakesNoMoreThanItsWay) {
  PortKnowledge known;
  known.damping = 0.05;
  known.speed = 0.5;
  const PortBalance balance(known, kPeriod);
  for (const double f : {0.01, 0.049, 0.051, 1.0, 20.0}) {
    const double expected =
        f <= 2.0 * 0.05 * 0.5 ? f * f * kPeriod / (4.0 * 0.05) : (f * 0.5 - 0.05 * 0.25) * kPeriod;
    EXPECT_NEAR(balance.need(Vec3(0, f, 0), kPeriod).at(1.0), expected, 1e-12 * expected);
    for (const double s : {0.02, 0.4})
      EXPECT_NEAR(balance.need(Vec3(0, f, 0), kPeriod).at(s),
                  searched_need(s * f, 0.05, 0.5 * kPeriod), 1e-9 * expected);
  }
  known.damping = 0.0;  // Without damping, only the largest displacement limits the energy.
  EXPECT_NEAR(PortBalance(known, kPeriod).need(Vec3(0, 3, 0), kPeriod).at(1.0), 3.0 * 0.5 * kPeriod,
              1e-15);
}

TEST(Account, OfInertiaAndSpeedWhatAllowsLessIsTaken) {
  PortKnowledge heavy = handle().translation, fast = heavy;
  heavy.speed = 100.0;  // The mass limits the displacement more.
  fast.speed = 0.05;
  const auto need = [](const PortKnowledge& known, double share) {
    PortBalance balance(known, kPeriod);
    balance.earned(Vec3::Zero(), Vec3::Zero(), kPeriod);
    return balance.need(Vec3(5, 0, 0), kPeriod).at(share);
  };
  for (const double share : {0.1, 0.5, 1.0}) {
    EXPECT_EQ(need(heavy, share), need(handle().translation, share));
    EXPECT_LT(need(fast, share), 0.6 * need(heavy, share));
  }
}

/// The account must not use a largest speed that the hand has just exceeded.
TEST(Account, AHandThatIsTooFastIsSeenAndMayDoAnything) {
  PortKnowledge known;
  known.damping = 0.05;
  known.speed = 0.5;
  known.quantum = 1e-5;
  PortBalance balance(known, kPeriod);
  const auto need = [&] { return balance.need(Vec3(5, 0, 0), kPeriod).at(1.0); };
  const double slow = need();
  balance.earned(Vec3(0.5 * kPeriod + 1e-5, 0, 0), Vec3::Zero(), kPeriod);
  EXPECT_FALSE(balance.strong_hand());
  EXPECT_EQ(need(), slow);
  balance.earned(Vec3(0.5 * kPeriod + 2e-5, 0, 0), Vec3::Zero(), kPeriod);
  EXPECT_TRUE(balance.strong_hand());
  EXPECT_NEAR(need(), 25.0 * kPeriod / (4.0 * 0.05), 1e-15);
  balance.earned(Vec3::Zero(), Vec3::Zero(), kPeriod);
  EXPECT_EQ(need(), slow);
}

/// The hand makes any movement of at most v h, and an encoder rounds the positions. The worst
/// movement uses the complete reserve.
TEST(Account, NoHandOfKnownSpeedTakesMoreThanTheDeviceBurned) {
  double least = 1.0, rendered = 0.0;
  for (std::uint64_t seed = 1; seed <= 100; ++seed) {
    Random random(seed);
    AccountConfig config;
    config.period = kPeriod;
    config.translation.damping = std::abs(random.decades(-2.0, 0.5));
    config.translation.speed = std::abs(random.decades(-1.5, 0.5));
    config.translation.quantum = random.chance(0.5) ? 2e-5 : 0.0;
    const double q = config.translation.quantum;
    PortAccount account(config);
    Vec3 x = Vec3::Zero(), shown = x;
    Command held;
    for (int n = 0; n < 2000; ++n) {
      const double way = config.translation.speed * kPeriod * random.uniform(0.0, 1.0);
      const Vec3 along = held.force().norm() > 0.0 && random.chance(0.7)
                             ? Vec3(held.force().normalized())
                             : random.direction();
      x += (random.chance(0.3) ? config.translation.speed * kPeriod : way) * along;
      if (x.norm() > 0.1) x *= 0.1 / x.norm();
      const Vec3 now = q > 0.0 ? Vec3((x / q).array().round() * q) : x;
      held = account.step(sample(now - shown, push(random.vector(-1.0, 1.5))));
      shown = now;
      least = std::min(least, account.balance());
      rendered += held.force().norm();
    }
  }
  EXPECT_GT(least, -1e-15);
  EXPECT_GT(rendered / (100.0 * 2000.0), 0.1);
}

}  // namespace
}  // namespace feltwire::account_speed_test

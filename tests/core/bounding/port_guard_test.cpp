#include "core/bounding/port_guard.hpp"

#include <gtest/gtest.h>

#include <algorithm>

#include "core/bounding/port_energy.hpp"
#include "tests/core/support.hpp"

namespace feltwire::port_guard_test {
namespace {

using namespace test;

constexpr double kDamping = 0.5;  // [N s/m]

TEST(PortGuard, LetsThroughWhatTheEnergyPaysFor) {
  const PortGuard guard(kDamping, Damping());
  const double energy = 2e-3;
  const double most = std::sqrt(4.0 * kDamping * energy / kModePeriod);  // f^2 T / (4 b) = E
  const Vec3 u = Vec3(1, 2, 2) / 3.0;
  const Command less{0.6 * 0.99 * most * u, 0.4 * 0.99 * most * u, Vec3::Zero()};
  EXPECT_EQ(guard.apply(less, energy, kModePeriod), less);
  const Command more = 3.0 * less;
  const Command given = guard.apply(more, energy, kModePeriod);
  EXPECT_NEAR(given.force().norm(), most, 1e-12 * most);
  EXPECT_NEAR(angle(given.force(), more.force()), 0.0, 1e-12);
  EXPECT_NEAR(given.elastic.norm() / given.frictional.norm(), 1.5, 1e-12);
  EXPECT_EQ(guard.apply(more, 0.0, kModePeriod).force(), Vec3::Zero());
  EXPECT_EQ(guard.apply(more, -1.0, kModePeriod).force(), Vec3::Zero());
}

TEST(PortGuard, TorqueThatNothingDampsIsNone) {
  const PortGuard guard(kDamping, Damping());
  const Command given =
      guard.apply({Vec3(0, 0, 1), Vec3::Zero(), Vec3(0.1, 0, 0)}, 1.0, kModePeriod);
  EXPECT_EQ(given.elastic, Vec3(0, 0, 1));
  EXPECT_EQ(given.torque, Vec3::Zero());
}

/// A hand that always takes all it can from commands as no scene would give them; sometimes it
/// moves as it likes, which burns something. Returns the least margin over all energy exchanged.
double least_margin(std::uint64_t seed, const Damping& damping, double believed, double& felt) {
  Random random(seed);
  const Damping turning(1e-3);
  const PortGuard guard(Mat3(believed * damping.matrix()), Mat3(believed * turning.matrix()));
  PortEnergy port(damping, turning, kModePeriod);
  const Mat3 inverse = damping.matrix().inverse();
  Command held;
  double exchanged = 0.0;
  for (int n = 0; n < 4000; ++n) {
    Vec3 moved = 0.5 * kModePeriod * inverse * held.force();
    Vec3 turned = greediest(held.torque, kModePeriod, 1e-3);
    if (random.chance(0.2)) moved = random.vector(-6.0, -3.0);
    if (random.chance(0.2)) turned = random.vector(-4.0, -2.0);
    port.step(held, moved, turned, kModePeriod);
    exchanged += std::abs(held.force().dot(moved)) + std::abs(held.torque.dot(turned));
    // The guard is told what was believed to be burned.
    const double margin = believed * port.burned() - port.delivered().total();
    held = guard.apply(random_command(random), margin, kModePeriod);
    felt = std::max(felt, held.force().norm());
  }
  return port.least_margin() / exchanged;
}

TEST(PortGuard, NoHandTakesMoreThanWasBurned) {
  const Damping axes(Vec3(0.3, 0.6, 2.0));
  for (std::uint64_t seed = 1; seed <= 40; ++seed) {
    double felt = 0.0;
    EXPECT_GE(least_margin(seed, kDamping, 1.0, felt), -1e-12) << seed;
    EXPECT_GE(least_margin(seed, axes, 1.0, felt), -1e-12) << seed;
    EXPECT_GT(felt, 0.1) << seed;
    EXPECT_LT(least_margin(seed, kDamping, 1.05, felt), -1e-4) << seed;
  }
}

TEST(HoldReserve, IsThePeriodWhereTicksAreExact) {
  HoldReserve reserve(1e-3);
  for (int i = 0; i < 5000; ++i) {
    reserve.saw(i % 2 == 0 ? 1e-3 : 0.2e-3);
    EXPECT_EQ(reserve.hold_time(), 1e-3);
  }
}

TEST(HoldReserve, ReckonsWithTwiceTheLatestOfTheLastSecondsAndAtMostOnePeriodMore) {
  HoldReserve reserve(1e-3);
  reserve.saw(1.1e-3);
  EXPECT_NEAR(reserve.hold_time(), 1.2e-3, 1e-15);
  for (int i = 0; i < 900; ++i) reserve.saw(1e-3);
  EXPECT_NEAR(reserve.hold_time(), 1.2e-3, 1e-15);
  for (int i = 0; i < 2200; ++i) reserve.saw(1e-3);  // forgotten
  EXPECT_EQ(reserve.hold_time(), 1e-3);
  reserve.saw(0.7);
  EXPECT_EQ(reserve.hold_time(), 2e-3);
}

}  // namespace
}  // namespace feltwire::port_guard_test

// Compares the port energy observer with closed forms.

#include "core/bounding/port_energy.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

namespace feltwire::port_energy_test {
namespace {

constexpr double kPeriod = 1e-3;

TEST(PortEnergy, AHeldForceDeliversForceTimesWay) {
  PortEnergy port(2.0, 0.1, kPeriod);
  const Command held{Vec3(1, 2, 3), Vec3(-4, 0, 1), Vec3(0.5, 0, 0)};
  port.step(held, Vec3(1e-3, 2e-3, -1e-3), Vec3(0.01, 5, 5), kPeriod);
  EXPECT_DOUBLE_EQ(port.delivered().elastic, 1e-3 + 4e-3 - 3e-3);
  EXPECT_DOUBLE_EQ(port.delivered().frictional, -4e-3 - 1e-3);
  EXPECT_DOUBLE_EQ(port.delivered().torque, 0.005);
  EXPECT_DOUBLE_EQ(port.delivered().total(), 2e-3 - 5e-3 + 0.005);
  EXPECT_DOUBLE_EQ(port.burned(), 2.0 * 6e-6 / kPeriod + 0.1 * (1e-4 + 50.0) / kPeriod);
}

TEST(PortEnergy, DryFrictionBurnsOverThePathThatIsCertain) {
  constexpr double kFriction = 0.3, kQuantum = 2e-5;
  PortEnergy port(0.0, 0.0, kPeriod, {kFriction, kQuantum});
  for (int n = 0; n < 100; ++n)  // An alternation by one quantum is no movement.
    port.step({}, Vec3(n % 2 == 0 ? kQuantum : -kQuantum, 0, 0), Vec3::Zero(), kPeriod);
  EXPECT_EQ(port.burned(), 0.0);
  port.step({}, Vec3(1e-3, 0, 0), Vec3::Zero(), kPeriod);
  EXPECT_NEAR(port.burned(), kFriction * (1e-3 - kQuantum) / std::sqrt(3.0), 1e-15);
}

// A sampled and held spring k is pressed by `depth` in equal steps and released. Every sample acts
// with the force of the previous sample. Each step d therefore delivers k d^2 / 2 beyond the
// spring's own energy, in both directions.
TEST(PortEnergy, ASampledSpringCycleDeliversTheHoldsEnergy) {
  const double k = 1000.0, step = 1e-4;
  const int steps = 100;
  PortEnergy port(0.0, 0.0, kPeriod);
  double depth = 0.0;
  for (int n = 0; n < steps; ++n, depth += step)
    port.step({Vec3(0, k * depth, 0), Vec3::Zero(), Vec3::Zero()}, Vec3(0, -step, 0), Vec3::Zero(),
              kPeriod);
  EXPECT_NEAR(port.delivered().elastic, -0.5 * k * depth * depth + steps * 0.5 * k * step * step,
              1e-12);
  EXPECT_EQ(port.violations(), 0u);
  for (int n = 0; n < steps; ++n, depth -= step)
    port.step({Vec3(0, k * depth, 0), Vec3::Zero(), Vec3::Zero()}, Vec3(0, step, 0), Vec3::Zero(),
              kPeriod);
  EXPECT_NEAR(port.delivered().elastic, 2 * steps * 0.5 * k * step * step, 1e-12);
  EXPECT_EQ(port.delivered().frictional, 0.0);
  EXPECT_GT(port.violations(), 0u);  // Without damping, the port delivers more energy than it gets.
  EXPECT_NEAR(port.least_margin(), -2 * steps * 0.5 * k * step * step, 1e-12);
}

// At Colgate's damping b = k T / 2, the device dissipates exactly the energy of this cycle.
TEST(PortEnergy, AtColgatesDampingTheSpringCycleIsPaidFor) {
  const double k = 1000.0, step = 1e-4, b = 0.5 * k * kPeriod;
  for (const double share : {1.0, 0.99}) {
    PortEnergy port(share * b, 0.0, kPeriod);
    double depth = 0.0;
    for (int n = 0; n < 200; ++n) {
      const double way = n < 100 ? step : -step;
      port.step({Vec3(k * depth, 0, 0), Vec3::Zero(), Vec3::Zero()}, Vec3(-way, 0, 0), Vec3::Zero(),
                kPeriod);
      depth += way;
    }
    EXPECT_EQ(port.violations() > 0, share < 1.0);
    EXPECT_NEAR(port.burned() - port.delivered().total(),
                (share - 1.0) * b * 200 * step * step / kPeriod, 1e-12);
  }
}

TEST(PortEnergy, OnlyLongHoldsChangeTheDampingCredit) {
  const auto burned = [](double hold_time) {
    PortEnergy port(3.0, 0.0, kPeriod);
    port.step({}, Vec3(1e-3, 0, 0), Vec3::Zero(), hold_time);
    return port.burned();
  };
  EXPECT_DOUBLE_EQ(burned(kPeriod), 3e-6 / kPeriod);
  EXPECT_DOUBLE_EQ(burned(0.0), 3e-6 / kPeriod);
  EXPECT_DOUBLE_EQ(burned(-1.0), 3e-6 / kPeriod);
  EXPECT_DOUBLE_EQ(burned(10 * kPeriod), 3e-7 / kPeriod);
}

TEST(PortEnergy, LeastMarginRemembersTheWorst) {
  PortEnergy port(1.0, 0.0, kPeriod);
  port.step({Vec3(1, 0, 0), Vec3::Zero(), Vec3::Zero()}, Vec3(5e-4, 0, 0), Vec3::Zero(), kPeriod);
  const double worst = 1.0 * 25e-8 / kPeriod - 5e-4;
  EXPECT_DOUBLE_EQ(port.least_margin(), worst);
  EXPECT_EQ(port.violations(), 1u);
  port.step({}, Vec3(1, 0, 0), Vec3::Zero(), kPeriod);
  EXPECT_DOUBLE_EQ(port.least_margin(), worst);
  EXPECT_EQ(port.violations(), 1u);
}

TEST(PortEnergy, WhatIsNotFiniteIsLeftOutAndCounted) {
  const double bad[] = {std::numeric_limits<double>::quiet_NaN(),
                        std::numeric_limits<double>::infinity(),
                        -std::numeric_limits<double>::infinity()};
  PortEnergy port(1.0, 1.0, kPeriod);
  const Vec3 one(1, 1, 1);
  std::uint64_t expected = 0;
  for (const double x : bad) {
    const Vec3 v(0, x, 0);
    port.step({v, one, one}, one, one, kPeriod);
    port.step({one, v, one}, one, one, kPeriod);
    port.step({one, one, v}, one, one, kPeriod);
    port.step({one, one, one}, v, one, kPeriod);
    port.step({one, one, one}, one, v, kPeriod);
    port.step({one, one, one}, one, one, x);
    port.step({v, Vec3::Zero(), Vec3::Zero()}, Vec3::Zero(), Vec3::Zero(), kPeriod);
    EXPECT_EQ(port.refused(), expected += 7);
  }
  // finite input with infinite energy
  port.step({1e300 * one, one, one}, 1e300 * one, one, kPeriod);
  EXPECT_EQ(port.refused(), ++expected);
  EXPECT_EQ(port.delivered().total(), 0.0);
  EXPECT_EQ(port.burned(), 0.0);
  EXPECT_EQ(port.violations(), 0u);
}

}  // namespace
}  // namespace feltwire::port_energy_test

// Compares `midpoint` with closed forms near the device. Tests where the method evaluates the
// scene, and how far it reduces the force of an oscillating hand.

#include "core/bounding/midpoint.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <numbers>

#include "core/bounding/bounding.hpp"

namespace feltwire::midpoint_test {
namespace {

constexpr double kPeriod = 1e-3;    // [s]
constexpr double kQuantum = 20e-6;  // [m]

BoundingStep step(double dz, const Command& command) {
  return {.displacement = Vec3(0, 0, dz), .hold_time = kPeriod, .command = command, .local = true};
}
Command push(double force) { return {.elastic = Vec3(0, 0, force)}; }

/// The hand oscillates along the normal with `amplitude` [m], `decay` [1/s] and `frequency` [Hz].
/// `command` gives the command at each height [m].
template <class Law, class AskedFor>
void swing(Law& law, double amplitude, double decay, double frequency, double time,
           AskedFor command) {
  double before = 0.0;
  for (int n = 1; n <= std::lround(time / kPeriod); ++n) {
    const double t = n * kPeriod;
    const double z =
        amplitude * std::exp(-decay * t) * std::sin(2 * std::numbers::pi * frequency * t);
    law.step(step(z - before, command(z)));
    before = z;
  }
}
template <class Law>
void swing(Law& law, double amplitude, double decay, double frequency, double time) {
  swing(law, amplitude, decay, frequency, time, [](double) { return push(5.0); });
}

TEST(Midpoint, AsksHalfASampleAhead) {
  const Midpoint<double> midpoint(kQuantum, kPeriod);
  const Probe probe = midpoint.probe(Vec3(2e-4, 0, 0), Vec3(0, 4e-3, 0));
  EXPECT_EQ(probe.offset, Vec3(1e-4, 0, 0));
  EXPECT_EQ(probe.rotation, Vec3(0, 2e-3, 0));
}

/// With 100 reversals a second, each twelve reversals reduce the force by one step.
TEST(Midpoint, AHandThatSwingsOnGetsLessOfTheWholeCommand) {
  Midpoint<double> midpoint(kQuantum, kPeriod);
  swing(midpoint, 2e-4, 0.0, 50.0, 1.0);
  const HandCredit learned = midpoint.hand_credit();
  EXPECT_EQ(learned.near_steps_down, 8u);  // 99 reversals
  EXPECT_NEAR(learned.near_share, std::pow(0.85, 8) * std::exp(0.05 * 1.0),
              0.02 * learned.near_share);
  const Command asked{
      .elastic = Vec3(0, 0, 5), .frictional = Vec3(2, 0, 0), .torque = Vec3(0, 0.1, 0)};
  const Command given = midpoint.step(step(0.0, asked));
  const double share = midpoint.hand_credit().near_share;
  EXPECT_EQ(given, share * asked);
}

TEST(Midpoint, ATenthOfTheForceIsLeftToAHandThatIsShaken) {
  Midpoint<double> midpoint(kQuantum, kPeriod);
  swing(midpoint, 2e-4, 0.0, 100.0, 10.0);
  EXPECT_GT(midpoint.hand_credit().near_steps_down, 50u);
  EXPECT_NEAR(midpoint.hand_credit().near_share, 0.1, 0.01);
}

/// The oscillation loses about a tenth of its amplitude with each movement.
TEST(Midpoint, AHandThatBouncesToRestGetsAllOfIt) {
  Midpoint<double> midpoint(kQuantum, kPeriod);
  swing(midpoint, 5e-3, 10.0, 50.0, 0.5);
  EXPECT_EQ(midpoint.hand_credit().near_steps_down, 0u);
  EXPECT_EQ(midpoint.step(step(0.0, push(5.0))), push(5.0));
}

TEST(Midpoint, AMovementThatIsIntendedOrSmallDoesNotCount) {
  const Midpoint<double> fresh(kQuantum, kPeriod);
  Midpoint<double> slow = fresh, small = fresh, in_the_air = fresh, along = fresh;
  swing(slow, 5e-3, 0.0, 10.0, 3.0);              // the speed of a voluntary movement
  swing(small, 0.9 * kQuantum, 0.0, 100.0, 1.0);  // less than two encoder steps between its ends
  swing(in_the_air, 2e-4, 0.0, 50.0, 1.0, [](double) { return Command{}; });
  swing(along, 2e-4, 0.0, 50.0, 1.0, [](double) { return Command{.elastic = Vec3(5, 0, 0)}; });
  for (const auto* midpoint : {&slow, &small, &in_the_air, &along})
    EXPECT_EQ(midpoint->hand_credit().near_steps_down, 0u);
  for (const auto* midpoint : {&slow, &small, &in_the_air, &along})
    EXPECT_EQ(midpoint->hand_credit().untold_lag, 0.0);
}

/// An oscillation of 25 Hz has 50 movements a second. Each six movements are one step.
TEST(Midpoint, AfterASlowSwingTheSceneIsAskedFartherAhead) {
  constexpr double kTold = 0.2e-3;  // [s]
  Midpoint<double> midpoint(kQuantum, kPeriod, kTold);
  swing(midpoint, 2e-3, 0.0, 25.0, 0.2);
  const HandCredit learned = midpoint.hand_credit();
  EXPECT_EQ(learned.untold_lag, Midpoint<double>::kLagStep);
  EXPECT_EQ(learned.near_share, 1.0) << "it costs no force";
  const Vec3 way(2e-4, 0, 0);
  const double margin = std::min(0.5, kTold / kPeriod);
  const double ahead = 0.5 + margin + (kTold + learned.untold_lag) / kPeriod;
  EXPECT_NEAR(midpoint.probe(way, way).offset.x(), ahead * way.x(), 1e-12);
  EXPECT_NEAR(midpoint.probe(way, way).rotation.x(), ahead * way.x(), 1e-12);
  swing(midpoint, 2e-3, 0.0, 25.0, 5.0);
  EXPECT_EQ(midpoint.hand_credit().untold_lag, Midpoint<double>::kMostUntold);
  EXPECT_EQ(midpoint.hand_credit().near_share, 1.0);
}

/// A handle of 75 g without any friction swings on a wall, whose force comes `lag` [s] late.
/// Returns the ratio of the swing after half a second to that of the beginning. `ahead` gives the
/// place at which the wall is asked for a movement.
template <class Ahead>
double swing_left(double wall, double lag, Ahead ahead) {
  constexpr double kMass = 0.075;
  double x = 1e-4, v = 0.0, before = x, force = 0.0, first = 0.0, last = 0.0;
  const auto fly = [&](double time) {
    x += (v + 0.5 * force / kMass * time) * time;
    v += force / kMass * time;
  };
  constexpr int kSamples = 500, kWindow = 50;
  for (int n = 0; n < kSamples; ++n) {
    const double asked = x + ahead(x - before);
    before = x;
    fly(lag);
    force = -wall * asked;
    fly(kPeriod - lag);
    if (n < kWindow) first = std::max(first, std::abs(x));
    if (n >= kSamples - kWindow) last = std::max(last, std::abs(x));
  }
  return last / first;
}

/// The stiffnesses are those of the table in docs/bounding.md, "The margin of a lag".
TEST(Midpoint, TheMarginOfALagKeepsABareHandleCalm) {
  struct Told {
    double lag, stiffest;  // [s], [N/m]
  };
  for (const Told& told :
       {Told{0.1e-3, 16.5e3}, {0.15e-3, 19e3}, {0.3e-3, 20e3}, {0.5e-3, 17.5e3}, {0.8e-3, 11e3}}) {
    const Midpoint<double> midpoint(0.0, kPeriod, told.lag);
    const auto asked = [&](double way) {
      return midpoint.probe(Vec3(way, 0, 0), Vec3::Zero()).offset.x();
    };
    double wall = 500.0;  // [N/m]
    while (swing_left(wall, told.lag, asked) < 1.0) wall += 100.0;
    EXPECT_NEAR(wall, told.stiffest, 700.0) << told.lag;
    // Without the margin, a wall takes damping from the handle.
    const auto without = [&](double way) { return (0.5 + told.lag / kPeriod) * way; };
    EXPECT_GT(swing_left(1e3, told.lag, without), 1.0) << told.lag;
  }
}

/// An oscillation that loses 40 % of its amplitude within three movements comes to rest by itself.
/// Encoder steps cause oscillations below four quanta when a hand presses on a stiff wall. Neither
/// oscillation may reduce the force.
TEST(Midpoint, ASlowSwingThatDiesAwayOrIsSmallTellsOfNoLag) {
  const Midpoint<double> fresh(kQuantum, kPeriod);
  Midpoint<double> dying = fresh, small = fresh, tapping = fresh;
  swing(dying, 5e-3, 9.0, 25.0, 0.5);
  swing(small, 1.8 * kQuantum, 0.0, 25.0, 1.0);
  swing(tapping, 2e-2, 0.0, 8.0, 3.0, [](double z) { return z < 0.0 ? push(5.0) : Command{}; });
  for (const auto* midpoint : {&dying, &small, &tapping})
    EXPECT_EQ(midpoint->hand_credit().untold_lag, 0.0);
}

/// The hand first moves far, then alternates between two encoder readings: 100 reversals a second.
TEST(Midpoint, ASwingOfTwoQuantaCountsAndOneOfAQuantumDoesNot) {
  for (const int quanta : {1, 2}) {
    Midpoint<double> midpoint(kQuantum, kPeriod);
    for (int n = 0; n < 1000; ++n) midpoint.step(step(kQuantum, push(5.0)));
    for (int n = 0; n < 1000; ++n) {
      const double way = (n / 10 % 2 == 0 ? quanta : -quanta) * kQuantum;
      midpoint.step(step(n % 10 == 0 ? way : 0.0, push(5.0)));
    }
    EXPECT_EQ(midpoint.hand_credit().near_steps_down > 5u, quanta == 2) << quanta;
  }
}

/// Half of each oscillation is outside the wall.
TEST(Midpoint, ASwingThatLeavesTheWallCountsToo) {
  Midpoint<double> midpoint(kQuantum, kPeriod);
  swing(midpoint, 2e-4, 0.0, 50.0, 0.5,
        [](double z) { return z < 0.0 ? push(-4e4 * z) : Command{}; });
  EXPECT_GT(midpoint.hand_credit().near_steps_down, 2u);
}

TEST(Midpoint, TheShareGrowsBackToTheWholeCommand) {
  Midpoint<double> midpoint(kQuantum, kPeriod);
  swing(midpoint, 2e-4, 0.0, 50.0, 0.2);
  const double low = midpoint.hand_credit().near_share;
  ASSERT_LT(low, 1.0);
  for (int n = 0; n < 2000; ++n) midpoint.step(step(0.0, push(5.0)));
  EXPECT_NEAR(midpoint.hand_credit().near_share, low * std::exp(2.0 * Midpoint<double>::kGrowth),
              1e-4);
  for (int n = 0; n < 20'000; ++n) midpoint.step(step(0.0, push(5.0)));
  EXPECT_EQ(midpoint.hand_credit().near_share, 1.0);
  EXPECT_EQ(midpoint.step(step(0.0, push(5.0))), push(5.0));
}

/// Marks every command of `bound` as late.
struct Late {
  Bounding& bound;
  void step(BoundingStep s) noexcept {
    s.local = false;
    bound.step(s);
  }
};

/// An oscillation under near forces must reduce only near forces. An oscillation under late forces
/// must reduce only the credited damping of late forces.
TEST(Midpoint, ShapedLearnsNearAndLateApart) {
  BoundingConfig config;
  config.mode = "shaped";
  config.period = kPeriod;
  config.damping = 0.5;
  config.quantum = kQuantum;
  Bounding late(config), near(config);
  Late of_late{late};
  swing(of_late, 2e-4, 0.0, 50.0, 0.5);
  swing(near, 2e-4, 0.0, 50.0, 0.5);
  EXPECT_EQ(late.hand_credit()->near_share, 1.0);
  EXPECT_EQ(late.hand_credit()->near_steps_down, 0u);
  EXPECT_GT(late.hand_credit()->steps_down, 0u);
  EXPECT_LT(near.hand_credit()->near_share, 1.0);
  EXPECT_GT(near.hand_credit()->near_steps_down, 0u);
  EXPECT_EQ(near.hand_credit()->steps_down, 0u);
  EXPECT_EQ(near.hand_credit()->damping, config.hand_damping);
}

}  // namespace
}  // namespace feltwire::midpoint_test

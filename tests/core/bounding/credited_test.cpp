// Compares the methods `credited` and `shaped` with closed forms: the slopes of the force, the
// reduction of the credited damping, and the commands that pass.

#include "core/bounding/credited.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

#include "core/bounding/bounding.hpp"

namespace feltwire::credited_test {
namespace {

constexpr double kPeriod = 1e-3;    // [s]
constexpr double kQuantum = 20e-6;  // [m]
constexpr CreditedLaw kForce{.damping = 0.5, .credit = 1.2};
constexpr CreditedLaw kTorque{.damping = 1e-3, .credit = 2e-3};
constexpr double kOwn = 2.0 * 0.5 / kPeriod;       // c [N/m]
constexpr double kCredited = 2.0 * 1.2 / kPeriod;  // c' - c [N/m]
constexpr double kStiffness = kOwn + kCredited;    // c' [N/m]

Credited<double> law(bool torque = false) { return {kForce, kTorque, kPeriod, kQuantum, torque}; }

BoundingStep step(const Vec3& dx, const Command& command) {
  return {.displacement = dx, .hold_time = kPeriod, .command = command};
}
Command push(double force) { return {.elastic = Vec3(0, 0, force)}; }

/// The reference is a spring of c at z(n), plus a spring of c' - c half a sample ahead, at z(n) +
/// (z(n) - z(n-1)) / 2.
TEST(Credited, AStiffWallRisesAndFallsByTheStiffnessThatIsCredited) {
  auto credited = law();
  double z = 0.0;
  for (int n = 0; n < 15; ++n) {
    const double way = n < 10 ? -1e-5 : 1e-5;
    z += way;
    const Command given = credited.step(step(Vec3(0, 0, way), push(50.0)));
    EXPECT_NEAR(given.elastic.z(), -kOwn * z - kCredited * (z + 0.5 * way), 1e-12);
  }
  const Command at_rest = credited.step(step(Vec3::Zero(), push(50.0)));
  EXPECT_NEAR(at_rest.elastic.z(), -kStiffness * z, 1e-12);
}

/// The method evaluates the scene half a period ahead at the same speed, for any hold time.
TEST(Credited, LooksHalfAPeriodAheadAlsoAfterALongHold) {
  auto credited = law();
  credited.step(step(Vec3(0, 0, -1e-5), push(50.0)));
  BoundingStep held_long = step(Vec3(0, 0, -3e-5), push(50.0));
  held_long.hold_time = 3.0 * kPeriod;
  EXPECT_NEAR(credited.step(held_long).elastic.z(), kOwn * 4e-5 + kCredited * (4e-5 + 0.5e-5),
              1e-12);
}

/// A handle has only its own damping, and a hand without damping pushes it against a far stiffer
/// wall. The method uses the speed of the last sample, so the oscillation grows by a quarter in
/// three seconds. With z(n) alone, 1.2 N s/m of damping would be missing, and the oscillation would
/// grow by a factor of 1.2 each period.
TEST(Credited, AnUndampedHandDoesNotSwingItselfUp) {
  // [kg], [N], [m] smaller than a counted oscillation
  constexpr double kMass = 0.1, kPush = 3.0, kBegin = 2e-4;
  Credited<double> credited(kForce, kTorque, kPeriod, 1e-3, false);  // no detection of oscillations
  double z = -kPush / kStiffness - kBegin, v = 0.0, before = 0.0, early = 0.0, late = 0.0;
  for (int n = 0; n < 4000; ++n) {
    const double force = credited.step(step(Vec3(0, 0, z - before), push(1e3))).elastic.z();
    before = z;
    const double a = (force - kPush - kForce.damping * v) / kMass;
    z += v * kPeriod + 0.5 * a * kPeriod * kPeriod;
    v += a * kPeriod;
    double& largest = n < 1000 ? early : late;
    if (n < 1000 || n >= 3000) largest = std::max(largest, std::abs(z + kPush / kStiffness));
  }
  EXPECT_GT(early, 0.5 * kBegin);
  EXPECT_LT(late, 2.0 * early);
  EXPECT_LT(early, 2.0 * kBegin);
}

TEST(Credited, ASoftWallIsRenderedAsItIs) {
  auto credited = law();
  for (int n = 1; n <= 50; ++n) {
    const double force = 1000.0 * 1e-5 * n;
    EXPECT_DOUBLE_EQ(credited.step(step(Vec3(0, 0, -1e-5), push(force))).elastic.z(), force);
  }
}

TEST(Credited, WhatWasHeldIsWhatTheNextStepBeginsFrom) {
  auto credited = law();
  credited.step(step(Vec3(0, 0, -1e-3), push(3.0)));
  credited.step(step(Vec3::Zero(), push(3.0)));  // The hand rests.
  credited.set_held(push(1.0));
  const Command given = credited.step(step(Vec3(0, 0, -1e-5), push(50.0)));
  EXPECT_NEAR(given.elastic.z(), 1.0 + kOwn * 1e-5 + kCredited * 1.5e-5, 1e-12);
}

TEST(Credited, FrictionHasAChannelOfItsOwnAndNeverMoreThanTheContactsShare) {
  auto credited = law();
  const Command wanted{.elastic = Vec3(0, 0, 10.0), .frictional = Vec3(-4.0, 0, 0)};
  const Vec3 dx(2e-3, 0, -1e-3);
  const Command given = credited.step(step(dx, wanted));
  const double share = (kOwn * 1e-3 + kCredited * 1.5e-3) / 10.0;
  EXPECT_NEAR(given.elastic.z(), 10.0 * share, 1e-12);
  EXPECT_NEAR(given.frictional.x(), -4.0 * share, 1e-12) << "its own channel would allow 9.2 N";
}

TEST(Credited, TorqueRisesWithItsOwnCredit) {
  auto credited = law(true);
  BoundingStep s = step(Vec3::Zero(), {.torque = Vec3(0, 0, 1.0)});
  s.rotation = Vec3(0, 0, -1e-2);
  EXPECT_NEAR(credited.step(s).torque.z(), (2.0 * 1e-3 * 1e-2 + 2.0 * 2e-3 * 1.5e-2) / kPeriod,
              1e-12);
}

/// Oscillates by `amplitude` [m] at `frequency` [Hz] in a contact.
template <class Law>
void swing(Law& law, double amplitude, double frequency, double time) {
  double before = 0.0;
  for (int n = 1; n <= std::lround(time / kPeriod); ++n) {
    const double z = amplitude * std::sin(2.0 * std::numbers::pi * frequency * n * kPeriod);
    law.step(step(Vec3(0, 0, z - before), push(5.0)));
    before = z;
  }
}

TEST(Credited, AHandThatSwingsLosesHalfOfItsCredit) {
  auto fast = law();
  swing(fast, 1e-4, 40.0, 0.5);
  EXPECT_GT(fast.hand_credit().steps_down, 2u);
  EXPECT_NEAR(fast.hand_credit().damping, 1.2 * std::pow(0.5, fast.hand_credit().steps_down),
              0.1 * fast.hand_credit().damping);
  auto slow = law();  // the speed of a voluntary movement
  swing(slow, 5e-3, 10.0, 2.0);
  EXPECT_EQ(slow.hand_credit().steps_down, 0u);
  auto small = law();  // the encoder noise of a resting hand
  swing(small, 1.9 * kQuantum, 100.0, 2.0);
  EXPECT_EQ(small.hand_credit().steps_down, 0u);
}

TEST(Credited, TheCreditGrowsBackToWhatItWas) {
  auto credited = law();
  swing(credited, 1e-4, 40.0, 0.2);
  const double low = credited.hand_credit().damping;
  ASSERT_LT(low, 1.2);
  for (int n = 0; n < 10'000; ++n) credited.step(step(Vec3::Zero(), push(5.0)));
  EXPECT_NEAR(credited.hand_credit().damping, low * std::exp(10.0 * Credited<double>::kGrowth),
              1e-6);
  for (int n = 0; n < 100'000; ++n) credited.step(step(Vec3::Zero(), push(5.0)));
  EXPECT_NEAR(credited.hand_credit().damping, 1.2, 1e-12);
}

TEST(Credited, SwingsInTheAirDoNotCount) {
  auto credited = law();
  double before = 0.0;
  for (int n = 1; n <= 1000; ++n) {
    const double z = 1e-3 * std::sin(2.0 * std::numbers::pi * 40.0 * n * kPeriod);
    credited.step(step(Vec3(0, 0, z - before), {}));
    before = z;
  }
  EXPECT_EQ(credited.hand_credit().steps_down, 0u);
}

TEST(Credited, AChangedSceneForgetsItsStiffnessAndNothingOfTheHand) {
  BoundingConfig config;
  config.mode = "shaped";
  config.period = kPeriod;
  config.damping = 0.5;
  config.hand_damping = 1.2;
  config.stiffness = 1200.0;
  Bounding shaped(config);
  swing(shaped, 2e-4, 40.0, 0.2);
  const auto risen = [&] {  // at a constant speed
    shaped.step(step(Vec3(0, 0, -1e-5), push(5.0)));
    shaped.set_held(push(1.0));
    return (shaped.step(step(Vec3(0, 0, -1e-5), push(5.0))).rendered.elastic.z() - 1.0) / 1e-5;
  };
  EXPECT_NEAR(risen(), 1200.0, 1e-6);
  const HandCredit before = *shaped.hand_credit();
  EXPECT_GT(before.steps_down, 0u);
  shaped.scene_changed();
  EXPECT_EQ(shaped.hand_credit()->steps_down, before.steps_down);
  EXPECT_EQ(shaped.hand_credit()->damping, before.damping);
  EXPECT_NEAR(risen(), 2.0 * (0.5 + before.damping) / kPeriod, 1.0);
}

TEST(Shaped, ACommandMadeAtTheDevicePassesAndALateOneIsCredited) {
  Shaped<double> shaped(law(), kQuantum, kPeriod);
  BoundingStep s = step(Vec3(0, 0, -1e-5), push(8.0));
  s.local = true;
  EXPECT_EQ(shaped.step(s), s.command);
  s.local = false;  // continues from the held force
  s.command = push(50.0);
  EXPECT_NEAR(shaped.step(s).elastic.z(), 8.0 + kStiffness * 1e-5, 1e-12);
}

}  // namespace
}  // namespace feltwire::credited_test

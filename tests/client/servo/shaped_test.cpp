// Tests a servo with a shaping method. It evaluates the local model half a sample ahead, the
// account is its last stage, and the force must not step.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <random>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::shaped_test {
namespace {

using namespace testing::servo;

constexpr double kStiffness = 200.0;  // [N/m]

SessionParameters modelled(std::string_view mode = "shaped") {
  SessionParameters p = parameters(mode);
  p.local_model = true;
  return p;
}

/// Returns a reply with a floor at z = 0. Its local model is valid within `reach` [m] of the
/// origin.
Reply floor_reply(std::uint64_t index, double stiffness = kStiffness, double reach = 0.04) {
  Reply r = reply(index, elastic(0, 0, 1));
  r.modelled = true;
  r.model.reach = reach;
  r.model.count = 1;
  r.model.patches[0].radius = 0.1;
  r.model.patches[0].material.stiffness = stiffness;
  return r;
}

/// Moves the hand to and fro in free space, and ends at z = 0. The device dissipates energy.
void burn(Bench& bench) {
  for (int n = 0; n < 400; ++n) bench.tick(at(0, 0, 0.01 * (1.0 + std::cos(0.05 * n))));
  for (int n = 100; n > 0; --n) bench.tick(at(0, 0, 1e-4 * n));
  bench.tick(at(0, 0, 0));
}

TEST(Shaped, AsksTheLocalModelHalfASampleAhead) {
  for (const char* mode : {"shaped", "midpoint"}) {
    Bench bench(modelled(mode));
    burn(bench);
    bench.servo.take(floor_reply(bench.servo.sample().index), bench.now);
    double z = 0.0;
    for (const double way : {-1e-4, -2e-4, -5e-5, -1e-4, 3e-5, 1e-4}) {
      z += way;
      EXPECT_NEAR(bench.tick(at(0, 0, z)).elastic.z(), -kStiffness * (z + 0.5 * way), 1e-12);
      EXPECT_TRUE(bench.servo.near());
    }
    EXPECT_EQ(bench.servo.statistics().law.account_cut, 0u);
    EXPECT_EQ(bench.servo.port().violations(), 0u);
  }
  // A method with its own bound evaluates the model at the device's position.
  Bench plain(modelled("none"));
  plain.tick();
  plain.servo.take(floor_reply(1), plain.now);
  EXPECT_NEAR(plain.tick(at(0, 0, -1e-3)).elastic.z(), 1e-3 * kStiffness, 1e-12);
}

TEST(Shaped, ADeviceThatHasBurnedNothingGivesNothing) {
  Bench bench(modelled());
  bench.tick(at(0, 0, 1e-6));
  bench.servo.take(floor_reply(1, 4e4), bench.now);
  bench.tick(at(0, 0, 1e-6));
  EXPECT_LT(bench.tick(at(0, 0, -2e-6)).force().norm(), 0.01);  // [N] The scene commands 0.14 N.
  EXPECT_EQ(bench.servo.statistics().law.account_cut, 1u);
  EXPECT_GT(bench.servo.account_cut(), 0.9);
  EXPECT_LE(bench.servo.account_cut(), 1.0);
  EXPECT_EQ(bench.servo.account()->statistics().overdrawn, 0u);
}

TEST(Shaped, BeyondTheModelItIsCreditedWithTheDampingOfAHand) {
  Bench bench(modelled());
  burn(bench);
  bench.servo.take(floor_reply(bench.servo.sample().index, kStiffness, 1e-3), bench.now);
  bench.tick(at(0, 0, 0));
  EXPECT_TRUE(bench.servo.near());
  const std::uint64_t before = bench.servo.statistics().local_model.hand_overs;
  // Only the reply's 1 N remains. This force rises by 2 (b + a) / T per metre.
  const double c = 2.0 * (0.5 + 1.5) / 1e-3;
  EXPECT_EQ(bench.tick(surely_at(0.01, 0, 0)).elastic.z(), 0.0);
  EXPECT_FALSE(bench.servo.near());
  EXPECT_EQ(bench.tick(surely_at(0.01, 0, 0)).elastic.z(), 0.0);
  EXPECT_NEAR(bench.tick(surely_at(0.01, 0, -1e-4)).elastic.z(), 1e-4 * 1e3 + 1.5e-4 * (c - 1e3),
              1e-12);
  EXPECT_EQ(bench.servo.statistics().local_model.hand_overs, before + 1);
  ASSERT_TRUE(bench.servo.hand_credit());
  EXPECT_EQ(bench.servo.hand_credit()->damping, 1.5);
}

TEST(Shaped, TheStiffestSurfaceLimitsHowFastALateForceRises) {
  ServoOptions options;
  options.scene_stiffness = 1500.0;
  for (const bool reloaded : {false, true}) {
    Bench bench(parameters("credited"), options);
    burn(bench);
    for (int n = 0; n < 2; ++n) bench.tick(at(0, 0, 0));  // The hand rests.
    bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 1)), bench.now);
    bench.tick(at(0, 0, 0));
    if (reloaded) {  // The new surfaces are unknown.
      Reply next = reply(bench.servo.sample().index, elastic(0, 0, 1));
      next.reloads = 1;
      bench.servo.take(next, bench.now);
    }
    const double c = reloaded ? 4000.0 : 1500.0;
    bench.tick(at(0, 0, 0));
    EXPECT_NEAR(bench.tick(at(0, 0, -1e-4)).elastic.z(), 1e-4 * 1e3 + 1.5e-4 * (c - 1e3), 1e-12);
  }
}

TEST(Shaped, AReloadForgetsNothingOfTheHand) {
  Bench bench(parameters("shaped"));
  burn(bench);
  std::uint8_t reloads = 0;
  const auto swing = [&](int ticks) {
    for (int n = 0; n < ticks; ++n) {
      Reply wall = reply(bench.servo.sample().index, elastic(0, 0, 2));
      wall.reloads = reloads;
      bench.servo.take(wall, bench.now);
      bench.tick(at(0, 0, 2e-4 * std::sin(0.25 * n)));
    }
    return *bench.servo.hand_credit();
  };
  const HandCredit before = swing(500);
  ASSERT_GT(before.steps_down, 1u);
  ++reloads;
  const HandCredit after = swing(1);
  EXPECT_EQ(after.steps_down, before.steps_down);
  EXPECT_NEAR(after.damping, before.damping, 1e-3 * before.damping);
  EXPECT_GT(swing(500).steps_down, before.steps_down);
}

TEST(Shaped, ALateCornerRisesWallByWall) {
  const auto force_of = [](bool told) {
    Bench bench(parameters("shaped"));
    burn(bench);
    for (int n = 0; n < 2; ++n) bench.tick(at(0, 0, 0));  // The hand rests.
    Reply corner = reply(bench.servo.sample().index, elastic(1, 0, 1));
    if (told) {
      corner.normals.add(Vec3::UnitX());
      corner.normals.add(Vec3::UnitZ());
    }
    bench.servo.take(corner, bench.now);
    bench.tick(at(0, 0, 0));
    bench.tick(at(0, 0, -1e-4));
    return bench.tick(at(-1e-5, 0, -1e-4)).elastic;
  };
  const double c = 2.0 * (0.5 + 1.5) / 1e-3;
  EXPECT_NEAR(force_of(true).z(), 1e-4 * c, 1e-12);
  EXPECT_NEAR(force_of(true).x(), 1e-5 * 1e3 + 1.5e-5 * (c - 1e3), 1e-12);
  EXPECT_EQ(force_of(false).x(), force_of(false).z()) << "one channel keeps the direction";
}

TEST(Shaped, AWallThatBecomesStifferUnderAHandThatRestsRisesSlowly) {
  Bench bench(modelled());
  burn(bench);
  bench.servo.take(floor_reply(bench.servo.sample().index), bench.now);
  for (int n = 1; n <= 25; ++n) bench.tick(at(0, 0, -2e-4 * n));
  bench.tick(at(0, 0, -5e-3));
  const double soft = bench.tick(at(0, 0, -5e-3)).elastic.z();
  EXPECT_NEAR(soft, 5e-3 * kStiffness, 1e-12);
  Reply harder = floor_reply(bench.servo.sample().index, 5.0 * kStiffness);
  harder.reloads = 1;
  harder.model.scene = 1;
  bench.servo.take(harder, bench.now);
  const double slew = bench.spec.max_force / (0.5 * bench.servo.parameters().hold_time);
  double before = soft;
  bool whole = false;
  for (int n = 0; n < 40; ++n) {
    const double now = bench.tick(at(0, 0, -5e-3)).elastic.z();
    EXPECT_LE(now - before, slew * 1e-3 + 1e-9);
    before = now;
    whole = whole || now > 4.9 * soft;
  }
  EXPECT_TRUE(whole);
}

// For seconds after a late tick, the servo keeps an energy reserve for hold times of 2 T. If the
// balance were empty, this reserve would cost most of the force.
TEST(Shaped, ALateTickCostsLittleForce) {
  Bench bench(modelled());
  bench.tick(at(0, 0, 1e-3));
  double z = 1e-3;
  const auto rest = [&](int ticks, Nanoseconds after = kPeriod) {
    double force = 0.0;
    for (int n = 0; n < ticks; ++n) {
      bench.servo.take(floor_reply(bench.servo.sample().index, 4e4), bench.now);
      force = bench.tick(at(0, 0, z), after).force().norm();
    }
    return force;
  };
  // The account must reduce the force, because the device has dissipated no energy.
  while (z > -2e-3) {
    z -= 2e-5;
    rest(1);
  }
  const double before = rest(20);
  EXPECT_GT(before, 0.5);
  EXPECT_LT(before, 40.0);  // [N] of 80 N
  rest(1, 3 * kPeriod / 2);
  EXPECT_GT(rest(5), 0.85 * before);
  EXPECT_EQ(bench.servo.account()->statistics().overdrawn, 0u);
}

TEST(Shaped, AFaultLosesTheBalance) {
  Bench bench(modelled());
  burn(bench);
  EXPECT_GT(bench.servo.account()->balance(), 1e-4);
  DeviceReading lost = at(0, 0, 0);
  lost.ok = false;
  bench.tick(lost);
  EXPECT_EQ(bench.servo.account()->balance(), 0.0);
  bench.tick(at(0, 0, 0.2));  // The movement during the fault is unknown.
  EXPECT_EQ(bench.servo.account()->balance(), 0.0);
  bench.tick(at(0, 0, 0.2001));
  EXPECT_GT(bench.servo.account()->balance(), 0.0);
}

TEST(Shaped, TheAccountKnowsNothingOfTheOperatorsDamping) {
  SessionParameters claimed = modelled();
  claimed.operator_damping = 5.0;
  Bench bench(modelled()), told(claimed);
  burn(bench);
  burn(told);
  EXPECT_EQ(told.servo.hand_credit()->damping, 5.0);
  EXPECT_EQ(told.servo.account()->balance(), bench.servo.account()->balance());
  EXPECT_EQ(told.servo.port().burned(), bench.servo.port().burned());
  // The account must also ignore the operator's damping under a bound that uses this damping.
  claimed.mode = "contact_frame";
  Bench bound(claimed);
  burn(bound);
  EXPECT_EQ(bound.servo.account()->balance(), bench.servo.account()->balance());
}

TEST(Shaped, TheAccountStandsBehindEveryModeThatBounds) {
  const auto stands = [](std::string_view mode, BoundingSide side = BoundingSide::client,
                         ServoOptions options = {}) {
    return Bench(parameters(mode, side), options).servo.account().has_value();
  };
  for (const BoundingMethod* method : bounding_methods()) {
    const bool bounds = method->name != kUnbounded;
    if (!stands_beside_scene(*method)) {
      EXPECT_EQ(stands(method->name), bounds) << method->name;
    }
    if (!method->shapes) {
      EXPECT_EQ(stands(method->name, BoundingSide::server), bounds) << method->name;
    }
  }
  ServoOptions without;
  without.account = false;
  for (const BoundingMethod* method : bounding_methods())
    if (!stands_beside_scene(*method) && !method->shapes) {
      EXPECT_FALSE(stands(method->name, BoundingSide::client, without)) << method->name;
    }
  EXPECT_THROW(stands("shaped", BoundingSide::client, without), std::invalid_argument);
  SessionParameters credited = parameters("per_axis");
  credited.operator_damping = 1.0;
  const Bench relies(credited);  // This account uses the hand's largest force.
  EXPECT_EQ(relies.servo.account()->outside_force(), relies.spec.hand_force);
  EXPECT_THROW(Bench(credited, without), std::invalid_argument);
}

/// Eq. (2) of docs/bounding.md leaves M >= sum F^2 T/(2b) in the port, twice the energy that any
/// hand can extract from the force. total_energy leaves nothing.
TEST(Shaped, PerAxisNeedsNoAccount) {
  const auto cuts = [](const char* mode) {
    Bench bench(parameters(mode));
    std::mt19937_64 random(5);
    std::normal_distribution<double> normal;
    Vec3 position = Vec3::Zero();
    bench.tick(at(0, 0, 0));
    for (int n = 0; n < 4000; ++n) {
      // The hand presses walls of 3 kN/m on each axis and shakes. Every third tick the force moves
      // the hand.
      const Vec3 way =
          n % 3 == 0 ? Vec3(1e-3 * bench.servo.held().force())
                     : Vec3(3e-4 * normal(random), 3e-4 * normal(random), 3e-4 * normal(random));
      position = (position + way).cwiseMax(-5e-3).cwiseMin(5e-3);
      bench.servo.take(reply(bench.servo.sample().index, {.elastic = -3e3 * position}), bench.now);
      bench.tick(at(position.x(), position.y(), position.z()));
    }
    EXPECT_GT(bench.servo.statistics().max_force, 1.0) << mode;
    return bench.servo.statistics().law.account_cut;
  };
  EXPECT_EQ(cuts("per_axis"), 0u);
  EXPECT_GT(cuts("total_energy"), 0u);
}

}  // namespace
}  // namespace feltwire::shaped_test

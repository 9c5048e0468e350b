// Compares the account with closed forms: the need of a force, the force that a balance covers, and
// the energy from a sample.

#include "core/bounding/account.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <stdexcept>

#include "core/bounding/device_account.hpp"
#include "tests/core/bounding/account_samples.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::account_test {
namespace {

using namespace test;

constexpr double kPeriod = kSamplePeriod;

TEST(Account, NeedOfAnUnknownHandIsTheStorageOfTheContactFrame) {
  PortKnowledge known;
  known.damping = 0.5;
  const PortBalance balance(known, kPeriod);
  const double f = 3.0;
  EXPECT_NEAR(balance.need(Vec3(f, 0, 0), kPeriod).at(1.0), f * f * kPeriod / (4.0 * 0.5), 1e-15);
}

TEST(Account, NeedIsTheMostThatAMovementWithinReachTakes) {
  Random random(3);
  for (int i = 0; i < 200; ++i) {
    PortKnowledge known = handle().translation;
    known.damping = std::abs(random.decades(-3.0, 1.5));
    known.mass = std::abs(random.decades(-2.0, 0.0));
    PortBalance balance(known, kPeriod);
    ReachableDisplacement reach(known);
    const Vec3 dx = random.vector(-6.0, -3.5), held = random.vector(-1.0, 1.0);
    balance.earned(dx, held, kPeriod);
    reach.moved(dx, held, kPeriod, kPeriod);
    const Vec3 f = random.vector(-1.0, 1.5);
    const EnergyNeed need = balance.need(f, kPeriod);
    for (const double s : {0.01, 0.3, 1.0}) {
      const double magnitude = s * f.norm();
      const double expected = searched_need(magnitude, known.damping.matrix()(0, 0),
                                            reach.along(f.normalized(), 1.0, s * f, kPeriod));
      EXPECT_NEAR(need.at(s), expected, 1e-9 * expected);
    }
  }
}

TEST(Account, NeedIsSmoothAndConvexWhereItsFormTurns) {
  PortBalance balance(handle(0.5).translation, kPeriod);
  balance.earned(Vec3::Zero(), Vec3::Zero(), kPeriod);
  const EnergyNeed need = balance.need(Vec3(20, 0, 0), kPeriod);
  const double turn = need.reach / need.free;
  ASSERT_GT(turn, 0.0);
  ASSERT_LT(turn, 1.0);
  const double below = need.first * turn * turn;
  EXPECT_NEAR(need.at(turn), below, 1e-12 * below);
  EXPECT_NEAR(2.0 * need.second * turn + need.linear, 2.0 * need.first * turn, 1e-9 * need.linear);
  EXPECT_GT(need.second, 0.0);
}

TEST(Account, TheNeedAlongADirectionCountsItsOwnDamping) {
  PortKnowledge known;
  known.damping = Vec3(0.2, 1.0, 5.0);
  const PortBalance balance(known, kPeriod);
  for (int axis = 0; axis < 3; ++axis) {
    const double b = known.damping.matrix()(axis, axis);
    EXPECT_NEAR(balance.need(2.0 * Vec3::Unit(axis), kPeriod).at(1.0), 4.0 * kPeriod / (4.0 * b),
                1e-15);
  }
  // f' B^-1 f T / 4 for any direction of the force.
  const Vec3 f(1.0, -2.0, 0.5);
  EXPECT_NEAR(balance.need(f, kPeriod).at(1.0),
              f.dot(known.damping.matrix().inverse() * f) * kPeriod / 4.0, 1e-15);
}

TEST(Account, RendersTheLargestShareThatTheBalancePaysFor) {
  Random random(5);
  int reduced = 0;
  for (int i = 0; i < 500; ++i) {
    AccountConfig config = handle(std::abs(random.decades(-3.0, 1.0)));
    config.rotation = {.damping = 1e-3, .mass = 1e-4, .outside_force = 0.5};
    PortAccount account(config);
    account.step(sample(random.vector(-4.0, -2.0), {}));  // dissipates some energy
    const double balance = account.balance();
    ASSERT_GT(balance, 0.0);
    const Command wanted{random.vector(-1.0, 2.0), random.vector(-1.0, 2.0),
                         random.vector(-3.0, 0.0)};
    PortBalance translation(config.translation, kPeriod), rotation(config.rotation, kPeriod);
    const Command given = account.step(sample(Vec3::Zero(), wanted));
    translation.earned(Vec3::Zero(), Vec3::Zero(), kPeriod);
    rotation.earned(Vec3::Zero(), Vec3::Zero(), kPeriod);
    const EnergyNeed force = translation.need(wanted.force(), kPeriod);
    const EnergyNeed torque = rotation.need(wanted.torque, kPeriod);
    if (force.at(1.0) + torque.at(1.0) <= balance) {
      EXPECT_EQ(given, wanted);
      continue;
    }
    ++reduced;
    const double s = given.torque.norm() / wanted.torque.norm();
    EXPECT_NEAR(force.at(s) + torque.at(s), balance, 1e-9 * balance);
    EXPECT_LE(force.at(s) + torque.at(s), balance);
    EXPECT_LT((given.elastic - s * wanted.elastic).norm(), 1e-12 * wanted.elastic.norm());
    EXPECT_LT((given.frictional - s * wanted.frictional).norm(), 1e-12 * wanted.frictional.norm());
  }
  EXPECT_GT(reduced, 100);
}

TEST(Account, AForceOnItsWayOutIsCutToTheBalanceHalfASampleAhead) {
  for (const double hold : {kPeriod, 3.0 * kPeriod}) {
    const AccountConfig config = handle();
    PortAccount account(config);
    account.step(sample(Vec3(50e-3, 0, 0), push(Vec3(5, 0, 0))));
    const Vec3 out(6e-5, 0, 0), in = -out;
    for (const Vec3& dx : {out, in}) {
      PortAccount now = account;
      const Command given = now.step(sample(dx, push(Vec3(1e3, 0, 0)), hold));
      const double delivered = 5.0 * dx.x() * kPeriod / hold;
      PortBalance port(config.translation, kPeriod);
      port.earned(Vec3(50e-3, 0, 0), Vec3::Zero(), kPeriod);
      port.earned(dx, Vec3(5, 0, 0), hold);
      const double need = port.need(Vec3(1e3, 0, 0), kPeriod).at(given.elastic.x() / 1e3);
      EXPECT_NEAR(need, now.balance() - 0.5 * std::max(0.0, delivered), 1e-9 * need);
    }
  }
}

TEST(Account, BehindABoundThatIsPassiveByItselfItLooksAtTheBalanceOnly) {
  AccountConfig config = handle();
  config.looks_ahead = false;
  PortAccount account(config);
  account.step(sample(Vec3(50e-3, 0, 0), push(Vec3(5, 0, 0))));
  const Vec3 out(6e-5, 0, 0);
  const Command given = account.step(sample(out, push(Vec3(1e3, 0, 0))));
  PortBalance port(config.translation, kPeriod);
  port.earned(out, Vec3(5, 0, 0), kPeriod);
  const double need = port.need(Vec3(1e3, 0, 0), kPeriod).at(given.elastic.x() / 1e3);
  EXPECT_NEAR(need, account.balance(), 1e-9 * need);
}

/// A tick may come after the stall detector's time of five periods. If the account covered such a
/// tick in advance, it would need about ten times the energy (docs/bounding.md, "A stall").
TEST(Account, AHoldOfFivePeriodsNeedsTenTimesTheEnergy) {
  for (const DeviceSpec& spec : builtin_devices()) {
    if (!(spec.least_mass > 0.0)) continue;
    PortBalance port(account_config(spec, kPeriod).translation, kPeriod);
    const Vec3 force(0.3 * spec.max_force, 0, 0);
    port.earned(Vec3::Zero(), force, kPeriod);
    const double once = port.need(force, kPeriod).at(1.0);
    const double five = port.need(force, 5.0 * kPeriod).at(1.0);
    EXPECT_GT(five, 8.0 * once) << spec.name;
    EXPECT_LT(five, 12.5 * once) << spec.name;
  }
}

TEST(Account, ACommandAtTheLimitIsNotScaledForItsRounding) {
  AccountConfig config;
  config.period = kPeriod;
  config.translation.damping = 0.5;
  PortAccount account(config);
  account.step(sample(Vec3(2e-3, 0, 0), {}));
  const double most = std::sqrt(4.0 * 0.5 * account.balance() / kPeriod);
  const Command above = push(Vec3((1.0 + 1e-13) * most, 0, 0));
  EXPECT_EQ(account.step(sample(Vec3::Zero(), above)), above);
  EXPECT_EQ(account.statistics().reduced, 0u);
}

TEST(Account, TheNeedOfAnyHandKnowsNothingOfTheMass) {
  const AccountConfig config = handle(0.05);
  PortAccount account(config);
  account.step(sample(Vec3::Zero(), {}));
  EXPECT_NEAR(account.need_of_any_hand(push(Vec3(0, 3, 0)), 2e-3), 9.0 * 2e-3 / (4.0 * 0.05),
              1e-15);
  EXPECT_EQ(account.need_of_any_hand({}, kPeriod), 0.0);
}

TEST(DeviceAccount, CountsOnWhatTheSpecificationIsSureOf) {
  DeviceSpec spec = builtin_device("phantom_premium_1.5");
  const AccountConfig known = account_config(spec, kPeriod);
  EXPECT_EQ(known.translation.mass, spec.least_mass);
  EXPECT_EQ(known.translation.coulomb_friction, spec.least_friction);
  EXPECT_EQ(known.translation.outside_force, spec.hand_force);
  EXPECT_EQ(known.translation.quantum, spec.position_resolution);
  EXPECT_EQ(known.translation.damping.least(), 0.005);
  EXPECT_TRUE(known.looks_ahead);
  EXPECT_NEAR(known.cap, kAccountCap * need_at_rest(known, push(Vec3(spec.max_force, 0, 0))),
              1e-15);
  const AccountConfig any = any_hand_account(spec, kPeriod);
  EXPECT_EQ(any.translation.mass, 0.0);
  EXPECT_EQ(any.translation.coulomb_friction, 0.0);
  EXPECT_FALSE(any.looks_ahead);
  EXPECT_TRUE(std::isinf(any.cap));
  // Torque counts if the device actuates and damps it.
  spec.rotational_damping = 1e-3;
  EXPECT_EQ(account_config(spec, kPeriod).rotation.damping.least(), 0.0);
  spec.rotation_sensed = spec.rotation_actuated = 3;
  spec.max_torque = 0.1;
  EXPECT_EQ(account_config(spec, kPeriod).rotation.damping.least(), 1e-3);
  EXPECT_NEAR(account_config(spec, kPeriod).cap - known.cap,
              kAccountCap * 0.1 * 0.1 * kPeriod / (4.0 * 1e-3), 1e-12);
  EXPECT_EQ(account_config(spec, kPeriod).rotation.mass, 0.0);
  spec.rotation.least_inertia = 2e-5;
  spec.rotation.hand_torque = 0.3;
  spec.rotation.resolution = 1e-4;
  spec.hand_speed = 2.0;
  const AccountConfig turning = account_config(spec, kPeriod);
  EXPECT_EQ(turning.rotation.mass, 2e-5);
  EXPECT_EQ(turning.rotation.outside_force, 0.3);
  EXPECT_EQ(turning.rotation.quantum, 1e-4);
  EXPECT_EQ(turning.translation.speed, 2.0);
}

TEST(Account, AForceThatWillBeHeldLongerNeedsMore) {
  const AccountConfig config = handle(0.5);
  PortAccount account(config);
  account.step(sample(Vec3(3e-4, 0, 0), {}));
  double before = 1e9;
  for (const double hold : {0.5 * kPeriod, kPeriod, 2.0 * kPeriod, 10.0 * kPeriod}) {
    PortAccount now = account;
    const double given = now.step(sample(Vec3::Zero(), push(Vec3(1e3, 0, 0))), hold).elastic.x();
    PortBalance port(config.translation, kPeriod);
    port.earned(Vec3::Zero(), Vec3::Zero(), kPeriod);
    const double longest = std::max(kPeriod, hold);
    EXPECT_NEAR(port.need(Vec3(1e3, 0, 0), longest).at(given / 1e3), now.balance(),
                1e-9 * now.balance());
    EXPECT_LE(given, before);
    before = given;
  }
}

TEST(Account, APartAboutWhichNothingIsKnownIsNotRendered) {
  PortAccount account(handle());  // The rotation is unknown.
  account.step(sample(Vec3(5e-3, 0, 0), {}));
  const Command given =
      account.step(sample(Vec3::Zero(), {Vec3(0.1, 0, 0), Vec3::Zero(), Vec3(0.1, 0, 0)}));
  EXPECT_EQ(given.elastic, Vec3(0.1, 0, 0));
  EXPECT_EQ(given.torque, Vec3::Zero());
}

TEST(Account, ASampleEarnsWhatWasBurnedLessWhatWasDelivered) {
  AccountConfig config = handle(0.5);
  PortAccount account(config);
  const Vec3 dx(3e-4, -1e-4, 2e-4);
  account.step(sample(dx, push(Vec3(1e-3, 0, 0))));
  const double burned = 0.5 * dx.squaredNorm() / kPeriod;
  EXPECT_NEAR(account.balance(), burned, 1e-18);
  account.step(sample(dx, {}, 2.0 * kPeriod));  // In a longer hold the damping dissipates less.
  EXPECT_NEAR(account.balance(), 1.5 * burned - 1e-3 * dx.x(), 1e-18);
}

TEST(Account, DryFrictionIsPaidForTheWayThatIsCertain) {
  AccountConfig config = handle(0.0);
  config.translation.coulomb_friction = 0.04;
  const double q = config.translation.quantum;
  PortAccount resting(config);
  for (int i = 0; i < 1000; ++i) resting.step(sample(Vec3((i % 2 ? q : -q), 0, 0), {}));
  EXPECT_EQ(resting.balance(), 0.0) << "an encoder that flickers shows no way";
  PortAccount moving(config);
  const double way = 0.1;
  for (int i = 0; i < 100; ++i) moving.step(sample(Vec3(way / 100, 0, 0), {}));
  EXPECT_NEAR(moving.balance(), 0.04 * (way - q) / std::sqrt(3.0), 1e-15);
}

TEST(Account, TheCapHoldsWhileNothingIsHeld) {
  AccountConfig config = handle(0.5);
  config.cap = need_at_rest(config, push(Vec3(8.5, 0, 0)));
  EXPECT_GT(config.cap, 0.0);
  PortAccount account(config);
  for (int i = 0; i < 2000; ++i) account.step(sample(Vec3(1e-3, 0, 0), {}));
  EXPECT_DOUBLE_EQ(account.balance(), config.cap);
  // The cap is the energy that a resting handle needs for its largest force.
  account.step(sample(Vec3::Zero(), push(Vec3(1e-9, 0, 0))));
  const Command full = account.step(sample(Vec3::Zero(), push(Vec3(8.5, 0, 0))));
  EXPECT_NEAR(full.elastic.x(), 8.5, 0.8);
  // A spring that the hand compresses may store more than the cap.
  for (int i = 0; i < 10; ++i) account.step(sample(Vec3(-1e-3, 0, 0), push(Vec3(8.5, 0, 0))));
  EXPECT_GT(account.balance(), 2.0 * config.cap);
}

TEST(Account, ADebtIsRepaidBeforeAnyForce) {
  PortAccount account(handle(0.5));
  account.step(sample(Vec3(5e-3, 0, 0), push(Vec3(3, 0, 0))));
  // The hand moves with the force during a long hold.
  account.step(sample(Vec3(2e-2, 0, 0), push(Vec3(3, 0, 0)), 0.05));
  ASSERT_TRUE(account.in_debt());
  EXPECT_EQ(account.statistics().overdrawn, 1u);
  const double debt = -account.balance();
  EXPECT_DOUBLE_EQ(account.statistics().largest_debt, debt);
  double burned = 0.0;
  while (account.in_debt()) {
    ASSERT_LT(burned, 2.0 * debt);
    const Command given = account.step(sample(Vec3(0, 1e-3, 0), push(Vec3(3, 0, 0))));
    burned += 0.5 * 1e-6 / kPeriod;
    if (account.in_debt()) {
      EXPECT_EQ(given, Command{});
    }
  }
  EXPECT_GE(burned, debt);
  EXPECT_EQ(account.statistics().overdrawn, 1u);
}

TEST(Account, OnlyWhatWasHeldIsCounted) {
  PortAccount account(handle(0.5));
  account.step(sample(Vec3(5e-3, 0, 0), push(Vec3(1, 0, 0))));
  const double before = account.balance();
  account.set_held({});
  account.step(sample(Vec3(1e-4, 0, 0), {}));
  EXPECT_NEAR(account.balance() - before, 0.5 * 1e-8 / kPeriod, 1e-18);
}

TEST(Account, ABadSampleLosesTheBalanceAndRendersNothing) {
  const Vec3 nan = Vec3::Constant(std::numeric_limits<double>::quiet_NaN());
  const auto start = [] {
    PortAccount account(handle(0.5));
    account.step(sample(Vec3(5e-3, 0, 0), push(Vec3(1, 0, 0))));
    return account;
  };
  const BoundingStep bad[] = {sample(nan, push(Vec3(1, 0, 0))),
                              sample(Vec3::Constant(1e300), push(Vec3(1, 0, 0))),
                              sample(Vec3::Zero(), push(Vec3(1, 0, 0)), 0.0),
                              sample(Vec3::Zero(), push(Vec3(1, 0, 0)), nan.x())};
  for (const BoundingStep& step : bad) {
    PortAccount account = start();
    EXPECT_GT(account.balance(), 0.0);
    EXPECT_EQ(account.step(step), Command{});
    EXPECT_EQ(account.balance(), 0.0);
  }
  PortAccount account = start();
  EXPECT_EQ(account.step(sample(Vec3::Zero(), push(nan))), Command{});
  EXPECT_GT(account.balance(), 0.0) << "a bad command says nothing of the handle";
  // Movement then dissipates energy, and the force returns.
  for (int i = 0; i < 3; ++i) account.step(sample(Vec3(5e-3, 0, 0), {}));
  EXPECT_EQ(account.step(sample(Vec3::Zero(), push(Vec3(1, 0, 0)))), push(Vec3(1, 0, 0)));
}

TEST(Account, AConfigurationThatCannotBeIsRefused) {
  AccountConfig period = handle(), cap = handle(), damping = handle();
  period.period = 0.0;
  cap.cap = -1.0;
  damping.rotation.damping = Damping(-1.0);
  for (const AccountConfig& config : {period, cap, damping})
    EXPECT_THROW(PortAccount{config}, std::invalid_argument);
}

TEST(Account, NothingAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  AccountConfig config = handle(0.5);
  config.rotation = {.damping = Vec3(1e-3, 2e-3, 1e-3), .mass = 1e-4, .outside_force = 0.5};
  PortAccount account(config);
  Random random(7);
  const std::size_t before = allocations();
  for (int i = 0; i < 10000; ++i) {
    BoundingStep step = sample(random.vector(-6.0, -3.0), random_command(random));
    step.rotation = random.vector(-5.0, -2.0);
    account.set_held(account.step(step));
  }
  EXPECT_EQ(allocations(), before);
}

TEST(Account, AnotherLawsAccountGoesOnWithWhatIsLeftAndWhatIsOwed) {
  AccountConfig config = handle(0.5);
  config.late = 1;
  for (const bool owes : {false, true}) {
    PortAccount before(config), after(config);
    before.step(sample(Vec3(1e-3, 0, 0), push(Vec3(0.2, 0, 0))));
    before.step(sample(Vec3::Zero(), push(Vec3(0.1, 0, 0))));
    before.step(sample(Vec3(owes ? 0.1 : 0.0, 0, 0), {}, owes ? 0.5 : kPeriod));
    EXPECT_EQ(before.in_debt(), owes);
    after.go_on_from(before);
    EXPECT_EQ(after.balance(), before.balance());
    EXPECT_EQ(after.statistics().largest_debt, before.statistics().largest_debt);
    // The device still applies forces that it got before.
    for (PortAccount* account : {&before, &after}) account->step(sample(Vec3(1e-4, 0, 0), {}));
    EXPECT_EQ(after.balance(), before.balance());
    const Command wanted = push(Vec3(1, 0, 0));
    EXPECT_EQ(after.step(sample(Vec3::Zero(), wanted)), before.step(sample(Vec3::Zero(), wanted)));
  }
  PortAccount owing(config);
  owing.begin_in_debt(0.5);
  EXPECT_EQ(owing.balance(), -0.5);
  EXPECT_EQ(owing.step(sample(Vec3(1e-4, 0, 0), push(Vec3(1, 0, 0)))), Command{});
}

}  // namespace
}  // namespace feltwire::account_test

// The energy account must give a hand no more energy than the device dissipated. The attack uses
// random devices over three decades, walls and unphysical commands, encoders, delays and late
// ticks.

#include <gtest/gtest.h>

#include <cmath>
#include <deque>

#include "core/bounding/account.hpp"
#include "tests/core/handle.hpp"

namespace feltwire::account_attack_test {
namespace {

using namespace test;

constexpr double kPeriod = 1e-3;  // [s]
#ifdef FELTWIRE_SANITIZED
constexpr int kDevices = 80;  // Sanitizers make a run forty times as slow.
constexpr double kShareOfExcess = 0.03;
#else
constexpr int kDevices = 800;
// The largest debt of all runs must exceed this share of the limit.
constexpr double kShareOfExcess = 0.1;
#endif

/// Parameters of the account, as fractions of the true values.
struct AssumedNumbers {
  double mass = 1.0, hand = 1.0, quantum = 1.0;
  double operator_damping = 0.0;  // [N s/m] declared in addition to the device's own damping
  bool late = true;               // The account gets the device's delay.
};

struct Device {
  Handle handle;
  PortKnowledge truth;

  explicit Device(Random& random) {
    handle.mass = std::abs(random.decades(-2.0, std::log10(0.5)));
    handle.viscous = std::abs(random.decades(-2.0, std::log10(5.0)));
    handle.dry = random.chance(0.5) ? std::abs(random.decades(-2.0, 0.0)) : 0.0;
    truth.mass = handle.mass;
    truth.damping = handle.viscous;
    truth.outside_force = std::abs(random.decades(std::log10(0.3), std::log10(20.0)));
    truth.quantum = random.chance(0.7) ? std::abs(random.decades(-6.0, -4.0)) : 0.0;
    truth.coulomb_friction = random.chance(0.5) ? handle.dry : 0.0;
  }
  AccountConfig told(const AssumedNumbers& told, std::size_t lag) const {
    AccountConfig config;
    config.period = kPeriod;
    config.translation = truth;
    config.translation.mass *= told.mass;
    config.translation.outside_force *= told.hand;
    config.translation.quantum *= told.quantum;
    config.translation.damping += told.operator_damping;
    config.late = told.late ? static_cast<int>(lag) : 0;
    return config;
  }
};

/// The source of commands: a stiff wall with delayed answers, or random unphysical commands.
struct Environment {
  bool wall;
  double stiffness;   // [N/m]
  std::size_t delay;  // samples
  std::deque<double> depth;

  explicit Environment(Random& random)
      : wall(random.chance(0.6)),
        stiffness(std::abs(random.decades(2.0, 5.0))),
        delay(static_cast<std::size_t>(random.uniform(0.0, 20.0))) {}
  Command command(Random& random, const Vec3& position) {
    if (!wall) return random_command(random);
    depth.push_back(std::max(0.0, -position.x()));
    if (depth.size() > delay + 1) depth.pop_front();
    return {Vec3(std::min(30.0, stiffness * depth.front()), 0, 0), Vec3::Zero(), Vec3::Zero()};
  }
};

struct Outcome {
  double least = 0.0;      // [J] smallest balance, from the true values
  double exchanged = 0.0;  // [J] exchanged energy
  // [N] sum of magnitudes. The account must render some force, otherwise the test proves nothing.
  double rendered = 0.0;
  AccountStatistics seen;
  bool force_in_debt = false;
  // largest debt divided by its limit, for a hand with excess strength
  double share_of_excess = 0.0;
};

/// `strength`: the hand's largest force as a share of the device's outside_force. `lag`: the delay
/// of the device [samples]. `promised`: the hold time that the account assumes [T].
Outcome attack(std::uint64_t seed, const AssumedNumbers& told, double strength, double longest,
               std::size_t lag, double promised) {
  Random random(seed);
  Device device(random);
  Environment environment(random);
  PortAccount account(device.told(told, lag));
  std::deque<Command> coming(lag);
  const double q = device.truth.quantum;
  const double b = device.truth.damping.matrix()(0, 0);
  const double hand_force_limit = strength * device.truth.outside_force;
  Outcome outcome;
  Vec3 shown = encoded(device.handle.position, q);
  Command held;
  // True sums over the complete path: the least energy that viscous damping dissipated (from
  // encoder readings), the path for dry friction, and the delivered energy.
  double burned = 0.0, delivered = 0.0, dry_path = 0.0, strongest = 0.0;
  Grip grip = Grip::none;
  for (int n = 0; n < 1500; ++n) {
    const double hold = kPeriod * (random.chance(0.8) ? 1.0 : random.uniform(0.1, longest));
    if (random.chance(0.2)) grip = any_grip(random);
    constexpr int kParts = 4;
    for (int i = 0; i < kParts; ++i) {
      const Vec3 before = device.handle.position;
      const Vec3 hand =
          hand_force(grip, random, held.force(), hand_force_limit, (i + 0.5) / kParts);
      device.handle.move(held.force() + hand, hold / kParts);
      dry_path += (device.handle.position - before).norm();
    }
    // The workspace is limited. The hand turns back at 0.1 m.
    if (device.handle.position.norm() > 0.1) grip = Grip::push;
    const Vec3 now = encoded(device.handle.position, q);
    const Vec3 dx = now - shown;
    shown = now;
    delivered += held.force().dot(dx);
    burned += b * dx.squaredNorm() / std::max(hold, kPeriod);
    outcome.exchanged += std::abs(held.force().dot(dx)) + b * dx.squaredNorm() / kPeriod;
    const double friction = device.truth.coulomb_friction * dry_path;
    outcome.least = std::min(outcome.least, burned + friction - delivered);
    const bool in_debt_before = account.balance() < 0.0;
    const Command given = account.step(
        {.displacement = dx, .hold_time = hold, .command = environment.command(random, now)},
        promised * kPeriod);
    if (account.in_debt() && in_debt_before && given != Command{}) outcome.force_in_debt = true;
    coming.push_back(given);
    held = coming.front();
    coming.pop_front();
    if (random.chance(0.1)) {  // The device gives less than commanded.
      held = random.uniform(0.0, 1.0) * held;
      account.set_held(held);
    }
    outcome.rendered += held.force().norm();
    strongest = std::max(strongest, held.force().norm());
  }
  outcome.seen = account.statistics();
  // f (F - F_h) 3 T^2 / (2 m): the energy from the displacement beyond the assumed limit.
  const double excess = hand_force_limit - device.truth.outside_force;
  outcome.share_of_excess = outcome.seen.largest_debt /
                            (strongest * excess * 1.5 * kPeriod * kPeriod / device.truth.mass);
  return outcome;
}

struct Sum {
  double worst = 0.0;  // smallest balance divided by the exchanged energy
  double share_of_excess = 0.0;
  double rendered = 0.0;  // [N] mean force
  std::uint64_t overdrawn = 0, strong_hand = 0;
  int losers = 0;  // number of devices with excess energy at the port
  bool force_in_debt = false;
};

Sum attack_all(int devices, const AssumedNumbers& told, double strength = 1.0, double longest = 1.0,
               std::size_t lag = 0, double promised = 1.0) {
  Sum sum;
  for (int i = 1; i <= devices; ++i) {
    const Outcome o = attack(static_cast<std::uint64_t>(i), told, strength, longest, lag, promised);
    const double relative = o.least / std::max(1e-9, o.exchanged);
    sum.worst = std::min(sum.worst, relative);
    sum.share_of_excess = std::max(sum.share_of_excess, o.share_of_excess);
    sum.losers += relative < -1e-9;
    sum.rendered += o.rendered / (1500.0 * devices);
    sum.overdrawn += o.seen.overdrawn;
    sum.strong_hand += o.seen.strong_hand;
    sum.force_in_debt |= o.force_in_debt;
  }
  return sum;
}

TEST(AccountAttack, NoHandTakesMoreThanTheDeviceBurned) {
  const Sum sum = attack_all(kDevices, {});
  EXPECT_EQ(sum.losers, 0);
  EXPECT_GT(sum.worst, -1e-12);
  EXPECT_EQ(sum.overdrawn, 0u);
  EXPECT_EQ(sum.strong_hand, 0u);
  EXPECT_GT(sum.rendered, 0.1);
}

/// The device applies forces late, and the account gets this delay.
TEST(AccountAttack, NorFromADeviceThatTakesForcesUpLate) {
  for (const std::size_t lag : {1U, 2U, 4U}) {
    const Sum sum = attack_all(kDevices / 2, {}, 1.0, 1.0, lag);
    EXPECT_EQ(sum.losers, 0) << lag;
    EXPECT_GT(sum.worst, -1e-12);
    EXPECT_EQ(sum.overdrawn, 0u);
    EXPECT_EQ(sum.strong_hand, 0u);
    EXPECT_GT(sum.rendered, 0.1);
  }
}

/// Ticks are late, but not later than the account assumes.
TEST(AccountAttack, NorFromTicksThatAreAsLateAsTheyLatelyWere) {
  for (const double longest : {1.3, 1.5, 2.0}) {
    const Sum sum = attack_all(kDevices / 2, {}, 1.0, longest, 0, longest);
    EXPECT_EQ(sum.losers, 0) << longest;
    EXPECT_GT(sum.worst, -1e-12);
    EXPECT_EQ(sum.overdrawn, 0u);
    EXPECT_EQ(sum.strong_hand, 0u);
    EXPECT_GT(sum.rendered, 0.1);
  }
  EXPECT_GT(attack_all(kDevices / 2, {}, 1.0, 1.5, 0, 1.0).overdrawn, 0u) << "not reckoned with";
}

TEST(AccountAttack, ToldWrongItLoses) {
  EXPECT_GT(attack_all(kDevices / 2, {.mass = 1.25}).losers, 0);
  EXPECT_GT(attack_all(kDevices / 2, {.hand = 0.8}).losers, 0);
  EXPECT_GT(attack_all(kDevices / 2, {.quantum = 0.0}).losers, 0);
  EXPECT_GT(attack_all(kDevices / 2, {.operator_damping = 1.2}).losers, 0);
  EXPECT_GT(attack_all(kDevices / 2, {.late = false}, 1.0, 1.0, 1).losers, 0);
}

TEST(AccountAttack, AHandThatIsTooStrongOverdrawsOnceAndIsSeen) {
  const Sum sum = attack_all(kDevices / 2, {}, 1.5);
  EXPECT_GT(sum.overdrawn, 0u);
  EXPECT_GT(sum.strong_hand, 0u);
  EXPECT_FALSE(sum.force_in_debt);
  EXPECT_GT(sum.share_of_excess, kShareOfExcess);
  EXPECT_LE(sum.share_of_excess, 1.0);
}

TEST(AccountAttack, AHoldThatIsTooLongIsADebt) {
  const Sum sum = attack_all(kDevices / 4, {}, 1.0, 50.0);
  EXPECT_GT(sum.overdrawn, 0u);
  EXPECT_FALSE(sum.force_in_debt);
}

}  // namespace
}  // namespace feltwire::account_attack_test

// The account skips terms without effect, stores values that seldom change, and multiplies by
// stored reciprocals. Its results must equal the unoptimized arithmetic.

#include <gtest/gtest.h>

#include <algorithm>
#include <cstdint>

#include "core/base/numeric.hpp"
#include "tests/core/bounding/plain_account.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::account_plain_test {
namespace {

using namespace test;

constexpr std::uint64_t kAccounts = rounds(400);
constexpr double kOff = 1e-9;  // tolerance as a share of the command and of the balance

/// Returns random knowledge of a port: damping of each kind or none, and every other quantity known
/// or unknown.
PortKnowledge any_knowledge(Random& random, double scale) {
  PortKnowledge known;
  const auto some = [&](double least, double most) {
    return scale * std::abs(random.decades(least, most));
  };
  if (random.chance(0.7)) {
    known.damping = some(-2.3, 1.0);
  } else if (random.chance(0.7)) {
    Mat3 root;
    for (int i = 0; i < 3; ++i) root.col(i) = random.direction();
    known.damping =
        Damping(Mat3(some(-2.0, 0.5) * (root * root.transpose() + 0.1 * Mat3::Identity())));
  }
  if (random.chance(0.5)) known.coulomb_friction = some(-3.0, 0.0);
  if (random.chance(0.8)) known.quantum = std::abs(random.decades(-6.0, -3.5));
  if (random.chance(0.7)) known.mass = some(-2.0, 0.0);
  if (random.chance(0.8)) known.outside_force = some(-0.5, 1.3);
  if (random.chance(0.2)) known.speed = std::abs(random.decades(-1.5, 0.5));
  return known;
}

/// A hand that mostly repeats its last step. The encoder rounds each position.
struct Movement {
  Vec3 step = Vec3::Zero();
  Vec3 next(Random& random, double quantum) {
    if (random.chance(0.2)) step = random.vector(-6.0, -3.0);
    step *= random.uniform(0.99, 1.01);
    if (random.chance(0.02)) return Vec3::Zero();
    return quantum > 0.0 ? Vec3((step / quantum).array().round() * quantum) : step;
  }
};

struct LimitCounts {
  std::uint64_t reduced = 0, strong_hand = 0, whole = 0;
};

void play(std::uint64_t seed, LimitCounts& seen) {
  Random random(seed);
  AccountConfig config;
  config.translation = any_knowledge(random, 1.0);
  config.rotation = any_knowledge(random, 1e-2);
  if (random.chance(0.5)) config.cap = std::abs(random.decades(-4.0, 0.0));
  config.looks_ahead = random.chance(0.7);
  config.learns_outside_force = random.chance(0.3);
  const bool even = random.chance(0.4);  // Every sample lasts a period.
  const double longest = config.period * random.uniform(1.0, 5.0);
  PortAccount account(config);
  PlainAccount plain(config);
  Movement way, turn;
  Command command;
  for (int n = 0; n < 2000; ++n) {
    BoundingStep s;
    s.displacement = way.next(random, config.translation.quantum);
    s.rotation = turn.next(random, config.rotation.quantum);
    s.hold_time = even ? config.period : random.uniform(0.05, 1.0) * longest;
    if (random.chance(0.001)) s.hold_time = 0.0;
    if (random.chance(0.001)) s.rotation.x() = std::numeric_limits<double>::quiet_NaN();
    if (random.chance(0.3)) {
      command = {random.vector(-3.0, 1.5), random.vector(-3.0, 1.0), random.vector(-4.0, 0.0)};
      if (random.chance(0.1)) command = {};
      if (random.chance(0.002)) command.torque.y() = std::numeric_limits<double>::infinity();
    }
    s.command = command;
    const double next_hold = even ? 0.0 : longest;
    const Command expected = plain.step(s, next_hold);
    const Command held = account.step(s, next_hold);
    if (!command.finite()) {
      ASSERT_EQ(held, Command{}) << seed << ' ' << n;
    } else {
      const double wrong = length(held.elastic - expected.elastic) +
                           length(held.frictional - expected.frictional) +
                           length(held.torque - expected.torque);
      const double all = length(command.force()) + length(command.torque);
      ASSERT_LE(wrong, kOff * std::max(1.0, all)) << seed << ' ' << n;
    }
    ASSERT_NEAR(account.balance(), plain.balance(), kOff * std::max(1.0, plain.balance()))
        << seed << ' ' << n;
    seen.whole += held == s.command && held != Command{};
    if (!random.chance(0.05)) continue;
    account.set_held(0.5 * held);
    plain.set_held(0.5 * held);
  }
  EXPECT_EQ(account.statistics().reduced, plain.reduced) << seed;
  EXPECT_EQ(account.statistics().strong_hand, plain.strong_hand) << seed;
  seen.reduced += plain.reduced;
  seen.strong_hand += plain.strong_hand;
}

TEST(AccountPlain, GivesWhatItsArithmeticWrittenOutGives) {
  LimitCounts seen;
  for (std::uint64_t seed = 1; seed <= kAccounts && !testing::Test::HasFatalFailure(); ++seed)
    play(seed, seen);
  EXPECT_GT(seen.reduced, 1000u);
  EXPECT_GT(seen.strong_hand, 1000u);
  EXPECT_GT(seen.whole, 1000u);
}

}  // namespace
}  // namespace feltwire::account_plain_test

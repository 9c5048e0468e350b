// The two-port bound limits the energy from the leader's port, for any hand, network, command and
// follower.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <vector>

#include "core/bounding/account.hpp"
#include "core/teleoperation/energy_counters.hpp"
#include "core/teleoperation/two_port_bound.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::two_port_test {
namespace {

using namespace test;

constexpr double kPeriod = 1e-3, kDamping = 0.5;  // [s], [N s/m]
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A follower and a network without rules. Counters grow at random or lie. Messages are late, lost,
/// repeated or reordered.
class Remote {
 public:
  explicit Remote(bool lies) : lies_(lies) {}
  void send(Random& random) {
    const double work = random.decades(-7.0, -2.0);
    (work > 0.0 ? honest_.given : honest_.taken) += std::abs(work);
    net_ = random.chance(0.01) ? 0.0 : net_ + work;
    largest_ = net_ == 0.0 ? 0.0 : largest_;
    if (net_ > largest_) honest_.pushed += net_ - largest_;
    largest_ = std::max(largest_, net_);
    EnergyCounters said = honest_;
    if (lies_ && random.chance(0.1)) said = {kNan, 0.0, 1.0};
    if (lies_ && random.chance(0.1)) said = {1e9, -1e9, 1e9};
    under_way_.push_back(said);
  }
  /// Delivers some of the sent messages, in any order, any number of times.
  template <class Take>
  void arrive(Random& random, const Take& take) {
    while (random.chance(0.5))
      take(under_way_[static_cast<std::size_t>(random.uniform(0.0, 0.999) *
                                               static_cast<double>(under_way_.size()))]);
  }
  const EnergyCounters& honest() const { return honest_; }

 private:
  bool lies_;
  EnergyCounters honest_;
  double net_ = 0.0, largest_ = 0.0;
  std::vector<EnergyCounters> under_way_;
};

struct Outcome {
  double worst = -1.0;  // (delivered - dissipated - credited) / exchanged
  double credit = 0.0;  // [J] credit from the follower
  double most_in_contact = 0.0;
  // [N] The bound must render some force, otherwise the test proves nothing.
  double rendered = 0.0;
  double taken = 0.0;  // [J] most energy in one contact, beyond the dissipated energy
};

/// A hand extracts the most energy of each sample from the held force, presses, or moves at random.
/// `told`: the assumed damping divided by the true damping.
Outcome attack(std::uint64_t seed, bool lies, const RemoteTrust& trust, double told = 1.0,
               bool account = false) {
  Random random(seed);
  Remote remote(lies);
  RemoteEnergy energy(trust);
  TwoPortBound bound(told * kDamping, kPeriod);
  AccountConfig config;
  config.period = kPeriod;
  config.translation.damping = Damping(told * kDamping);
  config.looks_ahead = false;
  PortAccount port(config);
  Outcome o;
  Vec3 held = Vec3::Zero();
  double delivered = 0.0, burned = 0.0, exchanged = 0.0, in_contact = 0.0, begun = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const Vec3 greediest = kPeriod / (2.0 * kDamping) * held;
    Vec3 dx = greediest;
    if (random.chance(0.4)) dx = -random.uniform(0.0, 4.0) * greediest + random.vector(-7.0, -3.0);
    if (random.chance(0.1)) dx = random.vector(-8.0, -3.0);
    delivered += held.dot(dx);
    burned += kDamping / kPeriod * dx.squaredNorm();
    exchanged += std::abs(held.dot(dx)) + kDamping / kPeriod * dx.squaredNorm();
    o.worst = std::max(o.worst, (delivered - burned - energy.credit()) / std::max(exchanged, 1e-9));
    o.taken = std::max(o.taken, delivered - burned - begun);
    remote.send(random);
    remote.arrive(random, [&](const EnergyCounters& c) { energy.take(c); });
    const double grown = energy.step(kPeriod);
    in_contact += grown;
    o.most_in_contact = std::max(o.most_in_contact, in_contact);
    const Vec3 command = random.chance(0.02) ? Vec3(Vec3::Zero()) : random.vector(-2.0, 3.0);
    if (account) {
      port.credit(grown);
      BoundingStep step;
      step.displacement = dx;
      step.hold_time = kPeriod;
      step.command.elastic = command;
      held = port.step(step).force();
    } else {
      held = bound.step({dx, kPeriod, command, energy.net()});
    }
    o.rendered += held.norm();
    if (held.isZero(0.0)) {
      bound.begin_contact();
      energy.begin_contact();
      in_contact = 0.0;
      begun = delivered - burned;
    }
  }
  o.credit = energy.credit();
  return o;
}

constexpr RemoteTrust kOwnRobot{};
constexpr double kRounding = 1e-12;

TEST(TwoPortProperty, NoHandTakesMoreThanTheDeviceBurnedAndTheEnvironmentGave) {
  for (const bool account : {false, true}) {
    double taken = -1.0, rendered = 0.0;
    for (const std::uint64_t seed : test::seeds(0, 200, 0)) {
      const Outcome o = attack(seed, seed % 2 == 1, kOwnRobot, 1.0, account);
      EXPECT_LE(o.worst, kRounding) << seed << ' ' << account;
      taken = std::max(taken, o.taken);
      rendered += o.rendered;
    }
    EXPECT_GT(taken, 1e-3);  // The credit must reach the hand.
    EXPECT_GT(rendered, test::rounds(1000));
  }
}

TEST(TwoPortProperty, ADampingToldFivePercentTooLargeIsFound) {
  for (const bool account : {false, true}) {
    double worst = -1.0;
    for (std::uint64_t seed = 0; seed < 20; ++seed)
      worst = std::max(worst, attack(seed, false, {0.0, 0.0}, 1.05, account).worst);
    EXPECT_GT(worst, 1e-6) << account;
  }
}

TEST(TwoPort, AFollowerThatLiesBuysNoMoreThanItIsTrustedWith) {
  constexpr RemoteTrust kLittle{.per_contact = 2e-3, .power = 0.5};
  for (const std::uint64_t seed : test::seeds(0, 50, 0)) {
    const Outcome o = attack(seed, true, kLittle);
    EXPECT_LE(o.most_in_contact, kLittle.per_contact * (1.0 + kRounding)) << seed;
    EXPECT_LE(o.credit, kLittle.power * 2000 * kPeriod * (1.0 + kRounding)) << seed;
    EXPECT_LE(o.worst, kRounding) << seed;
    EXPECT_EQ(attack(seed, true, {0.0, 0.0}).credit, 0.0) << seed;
  }
}

TEST(TwoPort, LostDoubledAndOvertakenCountersGiveTheSameAsAllInOrder) {
  Random random(7);
  std::vector<EnergyCounters> sent;
  Remote remote(false);
  RemoteEnergy in_order({10.0, 1e6}), mixed({10.0, 1e6});
  for (int n = 0; n < 300; ++n) {
    remote.send(random);
    sent.push_back(remote.honest());
    in_order.take(sent.back());
    in_order.step(kPeriod);
  }
  for (int n = 0; n < 1000; ++n)
    if (random.chance(0.3)) mixed.take(sent[static_cast<std::size_t>(random.uniform(0.0, 299.9))]);
  mixed.take(sent.back());
  mixed.take(sent.front());
  mixed.step(1.0);
  EXPECT_NEAR(mixed.credit(), in_order.credit(), 1e-12);
  EXPECT_NEAR(mixed.credit(), sent.back().pushed, 1e-12);
}

TEST(TwoPort, AWallThatPushesMovesTheHandOnlyWithItsEnergy) {
  // A force of 2 N pushes the hand back by 1 mm and does 2 mJ of work. Without credit the force
  // must fade.
  const auto pushed = [](double given) {
    RemoteEnergy energy(kOwnRobot);
    TwoPortBound bound(kDamping, kPeriod);
    energy.take({given, 0.0, given});
    energy.step(1.0);
    double work = 0.0;
    Vec3 held = Vec3::Zero();
    for (int n = 0; n < 1000; ++n) {
      const Vec3 dx(0.0, 0.0, held.norm() > 0.0 ? 1e-6 : 0.0);
      work += held.dot(dx);
      held = bound.step({dx, kPeriod, Vec3(0.0, 0.0, 2.0), energy.net()});
    }
    return work;
  };
  EXPECT_EQ(pushed(0.0), 0.0);
  EXPECT_NEAR(pushed(1e-2), 2e-3, 4e-6);  // enough for the complete work
  EXPECT_LE(pushed(1e-3), 1e-3 + 1e-6);   // at most the credit
  EXPECT_GT(pushed(1e-3), 0.5e-3);
}

TEST(TwoPort, AnotherRobotsTotalsAreNoGrowth) {
  RemoteEnergy energy({.per_contact = 10.0, .power = 1e6});
  energy.take({.given = 0.5, .taken = 0.1, .pushed = 0.5});
  EXPECT_EQ(energy.step(1e-3), 0.5);
  energy.restart();
  EXPECT_EQ(energy.step(1e-3), 0.0);
  energy.take({.given = 7.0, .taken = 3.0, .pushed = 4.0});
  EXPECT_EQ(energy.step(1e-3), 0.0);
  EXPECT_EQ(energy.net(), 0.0);
  energy.take({.given = 7.25, .taken = 3.0, .pushed = 4.25});
  EXPECT_EQ(energy.step(1e-3), 0.25);
  EXPECT_EQ(energy.net(), 0.25);
  EXPECT_EQ(energy.credit(), 0.75);
  // Smaller totals than before must count too.
  energy.restart();
  energy.take({.given = 1.0, .taken = 0.0, .pushed = 1.0});
  energy.take({.given = 1.5, .taken = 0.0, .pushed = 1.5});
  EXPECT_EQ(energy.step(1e-3), 0.5);
}

TEST(ContactEnergy, CountsASpringsWorkExactlyAndNoiseAsNothing) {
  constexpr double kStiffness = 2000.0, kDeep = 5e-3;
  ContactEnergy exact(0.0);
  constexpr int kSteps = 100;
  const auto press = [&](ContactEnergy& count, double noise) {
    double depth = 0.0;
    for (int n = 1; n <= 2 * kSteps; ++n) {
      const double now = kDeep * (n <= kSteps ? n : 2 * kSteps - n) / kSteps;
      const double wrong = n % 2 ? noise : -noise;
      count.moved(Vec3(-kStiffness * now + wrong, 0, 0), Vec3(now - depth, 0, 0), kPeriod);
      depth = now;
    }
    return count.counters();
  };
  const EnergyCounters all = press(exact, 0.0);
  EXPECT_NEAR(all.taken, 0.5 * kStiffness * kDeep * kDeep, 1e-12);
  EXPECT_NEAR(all.given, 0.5 * kStiffness * kDeep * kDeep, 1e-12);
  EXPECT_NEAR(all.pushed, 0.0, 1e-12);
  ContactEnergy careful(0.1);
  EXPECT_EQ(press(careful, 0.1).pushed, 0.0);
}

TEST(TwoPort, WhatIsNotFiniteRendersNothingAndMakesNothing) {
  TwoPortBound bound(kDamping, kPeriod);
  const Vec3 in(0.0, 0.0, -1e-3), out(0.0, 0.0, 2.0);
  bound.step({in, kPeriod, out, 0.0});
  EXPECT_GT(bound.step({in, kPeriod, out, 0.0}).norm(), 0.5);
  EXPECT_TRUE(bound.step({Vec3(kNan, 0, 0), kPeriod, out, 0.0}).isZero(0.0));
  // The energy W at the bound is unknown after NaN, so the force must be zero.
  EXPECT_TRUE(bound.step({Vec3::Zero(), kPeriod, out, 1.0}).isZero(0.0));
  EXPECT_TRUE(bound.step({in, kPeriod, Vec3(kNan, 0, 0), 1.0}).isZero(0.0));
  EXPECT_TRUE(bound.step({in, kPeriod, out, kNan}).allFinite());
}

}  // namespace
}  // namespace feltwire::two_port_test

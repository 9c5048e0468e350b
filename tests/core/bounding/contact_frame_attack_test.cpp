// Hands try to extract more energy from the contact frame's port than the device dissipated.

#include <gtest/gtest.h>

#include <cmath>
#include <functional>

#include "core/base/numeric.hpp"
#include "tests/core/contact_frame_fixture.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::contact_frame_attack_test {
namespace {

using namespace test;

/// The movement of a hand until the next sample, under the held force. The numbers are ratios to
/// the movement that extracts the most energy.
struct Movement {
  Vec3 displacement, rotation;
};
using Hand = std::function<Movement(Random&, const Command& held, double hold_time)>;

/// Extracts the most energy of one sample: exactly, with a perturbation, or scaled by a random
/// factor.
Movement greedy(Random& random, const Command& held, double time, double exact = 0.5) {
  Movement m{greediest(held.force(), time, kDamping),
             greediest(held.torque, time, kRotationalDamping)};
  if (!random.chance(exact)) {
    m.displacement = m.displacement * random.uniform(0.0, 3.0) + random.vector(-9.0, -3.0);
    m.rotation = m.rotation * random.uniform(0.0, 3.0) + random.vector(-9.0, -3.0);
  }
  return m;
}

/// Presses against the force to store energy, and then extracts this energy.
Movement alternating(Random& random, const Command& held, double time) {
  if (random.chance(0.5)) return greedy(random, held, time, 1.0);
  const double pressing = -random.uniform(0.0, 4.0);
  return {pressing * greediest(held.force(), time, kDamping) + random.vector(-7.0, -3.0),
          pressing * greediest(held.torque, time, kRotationalDamping) + random.vector(-7.0, -3.0)};
}

/// Extracts energy from one channel only, by a movement along or across the held normal.
Movement one_channel(Random& random, const Command& held, double time) {
  const Vec3 normal = direction(held.elastic);
  const Vec3 all = greediest(held.force(), time, kDamping);
  Movement m{random.chance(0.5) ? along(all, normal) : Vec3(all - along(all, normal)),
             Vec3::Zero()};
  m.displacement += random.vector(-9.0, -3.0);
  return m;
}

/// Moves at random.
Movement restless(Random& random, const Command&, double) {
  return {random.vector(-8.0, -2.0), random.vector(-8.0, -1.0)};
}

/// Returns both projections and both storages in turn.
BoundingConfig any_config(std::uint64_t seed) {
  return contact_frame(seed % 2 ? Projection::joint : Projection::cone,
                       seed / 2 % 2 ? Storage::minimal : Storage::elastic);
}

struct Outcome {
  PortEnergy observer{kDamping, kRotationalDamping, kPeriod};
  double worst = -1.0;  // largest (delivered - dissipated) / exchanged
  // [N] sum of magnitudes. The bound must render some force, otherwise the test proves nothing.
  double rendered = 0.0;
};

/// Plays random unphysical commands against a hand that reacts to the held force. `reduce` returns
/// the force that the device makes of a command.
Outcome attack(const BoundingConfig& bound, const Hand& hand, std::uint64_t seed, int steps,
               const std::function<Command(Random&, const Command&)>& reduce = {}) {
  Random random(seed);
  Bounding bounding(bound);
  Outcome outcome;
  Command held;
  double exchanged = 0.0;
  for (int n = 0; n < steps; ++n) {
    const double hold_time = kPeriod * random.uniform(0.2, 1.0);
    Movement moved = hand(random, held, kPeriod);
    if (random.chance(0.02)) moved = {Vec3::Zero(), Vec3::Zero()};
    outcome.observer.step(held, moved.displacement, moved.rotation, hold_time);
    exchanged += std::abs(held.force().dot(moved.displacement)) +
                 std::abs(held.torque.dot(moved.rotation)) +
                 kDamping / kPeriod * moved.displacement.squaredNorm() +
                 kRotationalDamping / kPeriod * moved.rotation.squaredNorm();
    if (exchanged > 0.0) {
      const double excess = outcome.observer.delivered().total() - outcome.observer.burned();
      outcome.worst = std::max(outcome.worst, excess / exchanged);
    }
    held = bounding.step({moved.displacement, moved.rotation, hold_time, random_command(random)})
               .rendered;
    if (reduce) {
      held = reduce(random, held);
      bounding.set_held(held);
    }
    outcome.rendered += held.force().norm() + held.torque.norm();
  }
  return outcome;
}

struct Attack {
  const char* name;
  Hand hand;
};
const Attack kAttacks[] = {
    {"greedy", [](Random& r, const Command& h, double t) { return greedy(r, h, t); }},
    {"nearly always exact",
     [](Random& r, const Command& h, double t) { return greedy(r, h, t, 0.95); }},
    {"alternating", alternating},
    {"one channel", one_channel},
    {"restless", restless},
};

TEST(ContactFrame, NoHandTakesMoreThanTheDeviceBurned) {
  for (const Attack& a : kAttacks) {
    double worst = -1.0, rendered = 0.0;
    for (const std::uint64_t seed : test::seeds(0, 200, 20)) {
      const Outcome o = attack(any_config(seed), a.hand, seed, 4000);
      worst = std::max(worst, o.worst);
      rendered += o.rendered;
      EXPECT_EQ(o.observer.violations(), 0u) << a.name << " seed " << seed;
    }
    EXPECT_LE(worst, 1e-12) << a.name;
    EXPECT_GT(rendered, 1.0) << a.name;
  }
}

// The hands of the test above must gain energy when the bound assumes more damping than the device
// has.
TEST(ContactFrame, TheSameHandWinsAgainstFivePercentTooMuchDamping) {
  for (std::uint64_t variant = 0; variant < 4; ++variant) {
    BoundingConfig boasting = any_config(variant);
    boasting.damping = 1.05 * kDamping;
    boasting.rotational_damping = 1.05 * kRotationalDamping;
    double worst = -1.0;
    std::uint64_t violations = 0;
    for (std::uint64_t seed = 0; seed < 10; ++seed) {
      const Outcome o = attack(boasting, kAttacks[0].hand, seed, 4000);
      worst = std::max(worst, o.worst);
      violations += o.observer.violations();
    }
    EXPECT_GT(worst, 1e-3) << variant;
    EXPECT_GT(violations, 0u) << variant;
  }
}

TEST(ContactFrame, WhateverTheDeviceMakesSmallerStaysPassive) {
  const std::function<Command(Random&, const Command&)> reductions[] = {
      // a fade or a saturation
      [](Random& r, const Command& c) { return r.uniform(0.0, 1.0) * c; },
      [](Random& r, const Command& c) {  // scales or drops each part separately
        return Command{r.uniform(0.0, 1.0) * c.elastic, (r.chance(0.5) ? 0.0 : 1.0) * c.frictional,
                       r.uniform(-1.0, 1.0) * c.torque};
      },
      // rotates the force arbitrarily, and reports any split into parts
      [](Random& r, const Command& c) {
        const Vec3 force = c.force().norm() * r.direction();
        const Vec3 elastic = force.norm() * r.uniform(0.0, 3.0) * r.direction();
        return Command{elastic, force - elastic, c.torque.norm() * r.direction()};
      },
  };
  for (const auto& reduce : reductions)
    for (const Attack& a : kAttacks) {
      double worst = -1.0;
      for (const std::uint64_t seed : test::seeds(0, 20, 0))
        worst = std::max(worst, attack(any_config(seed), a.hand, seed, 4000, reduce).worst);
      EXPECT_LE(worst, 1e-12) << a.name;
    }
}

TEST(ContactFrame, SaturationStaysPassive) {
  for (const Attack& a : kAttacks)
    for (const std::uint64_t seed : test::seeds(0, 10, 0)) {
      BoundingConfig saturating = any_config(seed);
      saturating.max_force = 0.3;
      saturating.max_torque = 1e-3;
      EXPECT_LE(attack(saturating, a.hand, seed, 4000).worst, 1e-12) << a.name;
    }
}

/// An independent energy balance of a port in true values: dissipated minus delivered energy.
struct Ledger {
  double damping;
  double balance = 0.0;    // [J] dissipated - delivered
  double exchanged = 0.0;  // [J] exchanged energy
  void account(const Vec3& force, const Vec3& displacement, double hold_time) {
    const double burned = damping * displacement.squaredNorm() / std::max(hold_time, kPeriod);
    balance += burned - force.dot(displacement);
    exchanged += burned + std::abs(force.dot(displacement));
  }
  /// Returns the most energy that the hand can extract in the next sample, if it lasts T.
  double at_stake(const Vec3& force) const {
    return force.squaredNorm() * kPeriod / (4.0 * damping);
  }
};

// Faults overdraw the port, and no bound can prevent this. The bound must still render a force only
// if the balance covers the worst movement of the hand.
struct Faults {
  double longest_hold = 1.0;    // [T]
  double skipped_writes = 0.0;  // probability that the device keeps the previous force
  double lost_movements = 0.0;  // probability that the bound gets NaN
};
void no_force_on_credit(const Faults& faults) {
  int in_debt = 0, rendered = 0;
  for (const std::uint64_t seed : test::seeds(0, 60, 6)) {
    Random random(seed);
    Bounding bounding(any_config(seed));
    Ledger force{kDamping}, torque{kRotationalDamping};
    Command held;
    for (int n = 0; n < 4000; ++n) {
      const double hold_time =
          random.chance(0.1) ? kPeriod * random.uniform(1.0, faults.longest_hold) : kPeriod;
      Movement moved = kAttacks[seed % std::size(kAttacks)].hand(random, held, hold_time);
      // Random movement repays debts.
      if (random.chance(0.5)) moved = restless(random, held, hold_time);
      force.account(held.force(), moved.displacement, hold_time);
      torque.account(held.torque, moved.rotation, hold_time);
      BoundingStep told{moved.displacement, moved.rotation, hold_time, random_command(random)};
      if (random.chance(faults.lost_movements)) told.displacement.x() = std::nan("");
      if (random.chance(faults.lost_movements)) told.rotation.y() = std::nan("");
      const Bounded out = bounding.step(told);
      in_debt += out.in_debt;
      rendered += out.rendered.force().norm() > 0.0;
      if (out.rendered.force().norm() > 0.0) {
        ASSERT_GE(force.balance - force.at_stake(out.rendered.force()), -1e-12 * force.exchanged)
            << "seed " << seed << " step " << n;
      }
      if (out.rendered.torque.norm() > 0.0) {
        ASSERT_GE(torque.balance - torque.at_stake(out.rendered.torque), -1e-12 * torque.exchanged)
            << "seed " << seed << " step " << n;
      }
      if (random.chance(faults.skipped_writes))
        bounding.set_held(held);
      else
        held = out.rendered;
    }
  }
  EXPECT_GT(in_debt, 0);
  EXPECT_GT(rendered, 1000);
}

TEST(ContactFrame, OverlongHoldsAreRepaidBeforeAnyForce) {
  no_force_on_credit({.longest_hold = 5.0});
}
TEST(ContactFrame, SkippedWritesAreRepaidBeforeAnyForce) {
  no_force_on_credit({.skipped_writes = 0.2});
}
TEST(ContactFrame, AMovementNotKnownCountsAsTheWorst) {
  no_force_on_credit({.longest_hold = 5.0, .lost_movements = 0.1});
}
TEST(ContactFrame, AllFaultsTogether) {
  no_force_on_credit({.longest_hold = 5.0, .skipped_writes = 0.2, .lost_movements = 0.05});
}

}  // namespace
}  // namespace feltwire::contact_frame_attack_test

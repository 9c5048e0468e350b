// No hand may break the limits of the safety stage, for any limits.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/safety/safety.hpp"
#include "tests/core/contact_frame_fixture.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::safety_attack_test {
namespace {

using namespace test;

SafetyLimits any_limits(Random& random) {
  const auto channel = [&](double scale) {
    ChannelLimits c;
    if (random.chance(0.5)) c.max = scale * std::abs(random.decades(-2, 2));
    if (random.chance(0.5)) c.slew = scale * std::abs(random.decades(0, 4));
    if (random.chance(0.5)) c.speed = std::abs(random.decades(-2, 1));
    if (random.chance(0.3)) c.small = scale * std::abs(random.decades(-2, 1));
    return c;
  };
  SafetyLimits limits{channel(1.0), channel(1e-2)};
  if (random.chance(0.5)) limits.ramp_up = random.uniform(0.0, 2.0);
  return limits;
}

TEST(SafetyAttack, OnlyEverScalesDownEachChannelByOneFactor) {
  for (const std::uint64_t seed : test::seeds(0, 100, 10)) {
    Random random(seed);
    SafetyStage stage(any_limits(random));
    for (int n = 0; n < 500; ++n) {
      const Command command = random_command(random);
      SafetyStep s{.commanded = command, .bounded = command, .displacement = random.vector(-6, -2)};
      s.rotation = random.vector(-6, -2);
      s.hold_time = kPeriod * random.uniform(-0.5, 3.0);
      s.original = random.chance(0.5);
      if (random.chance(0.5)) s.bounded = random.uniform(0.0, 1.0) * s.bounded;
      const Command& in = s.bounded;
      const Command out = stage.apply(s).rendered;
      const double in_force = in.force().norm(), in_torque = in.torque.norm();
      const double share = in_force > 0.0 ? out.force().norm() / in_force : 0.0;
      const double torque_share = in_torque > 0.0 ? out.torque.norm() / in_torque : 0.0;
      ASSERT_LE(share, 1.0 + 1e-15);
      ASSERT_LE(torque_share, 1.0 + 1e-15);
      if (in_force > 0.0) {  // If the sum of the two parts is zero, the direction is undefined.
        ASSERT_LE((out.elastic - share * in.elastic).norm(), 1e-12 * in.elastic.norm());
        ASSERT_LE((out.frictional - share * in.frictional).norm(), 1e-12 * in.frictional.norm());
      }
      ASSERT_LE((out.torque - torque_share * in.torque).norm(), 1e-12 * in_torque);
    }
  }
}

struct Attack {
  double worst = -1.0;  // largest (delivered - dissipated) / exchanged
  std::uint64_t violations = 0;
  int limited = 0, slewed = 0, too_fast = 0, ramped = 0, waiting = 0, rendered = 0;
};

/// A hand extracts the most energy of each sample from the held force, or sometimes moves
/// differently. The stage is behind a contact frame, which gets the held force.
void attack(std::uint64_t seed, Attack& sum) {
  Random random(seed);
  Bounding bounding(contact_frame(seed % 2 ? Projection::joint : Projection::cone,
                                  seed / 2 % 2 ? Storage::minimal : Storage::elastic));
  SafetyStage stage(any_limits(random));
  PortEnergy port(kDamping, kRotationalDamping, kPeriod);
  Command held;
  double exchanged = 0.0;
  for (int n = 0; n < 4000; ++n) {
    const double hold_time = kPeriod * random.uniform(0.2, 1.0);
    Vec3 displacement = greediest(held.force(), kPeriod, kDamping);
    Vec3 rotation = greediest(held.torque, kPeriod, kRotationalDamping);
    if (random.chance(0.4)) {
      displacement = random.uniform(-4.0, 3.0) * displacement + random.vector(-9.0, -3.0);
      rotation = random.uniform(-4.0, 3.0) * rotation + random.vector(-9.0, -3.0);
    }
    port.step(held, displacement, rotation, hold_time);
    exchanged += std::abs(held.force().dot(displacement)) + std::abs(held.torque.dot(rotation)) +
                 kDamping / kPeriod * displacement.squaredNorm() +
                 kRotationalDamping / kPeriod * rotation.squaredNorm();
    if (exchanged > 0.0)
      sum.worst = std::max(sum.worst, (port.delivered().total() - port.burned()) / exchanged);

    const Command command = random_command(random);
    const Bounded bounded = bounding.step({displacement, rotation, hold_time, command});
    const Safeguarded safe = stage.apply({.commanded = command,
                                          .original = random.chance(0.5),
                                          .bounded = bounded.rendered,
                                          .displacement = displacement,
                                          .rotation = rotation,
                                          .hold_time = hold_time});
    held = safe.rendered;
    bounding.set_held(held);
    sum.limited += safe.limited;
    sum.slewed += safe.slewed;
    sum.too_fast += safe.too_fast;
    sum.ramped += safe.ramped;
    sum.waiting += safe.waiting;
    sum.rendered += held.force().norm() > 0.0;
  }
  sum.violations += port.violations();
}

TEST(SafetyAttack, BehindTheContactFrameNoHandTakesMoreThanTheDeviceBurned) {
  Attack all;
  for (const std::uint64_t seed : test::seeds(0, 400, 40)) attack(seed, all);
  EXPECT_EQ(all.violations, 0u);
  EXPECT_LE(all.worst, 1e-12);
  // Every limit must be active at some time.
  for (const int times : {all.limited, all.slewed, all.too_fast, all.ramped, all.waiting})
    EXPECT_GT(times, test::rounds(100));
  EXPECT_GT(all.rendered, test::rounds(100'000));
}

/// Presses in while the ramp gives almost no force, rests until the ramp ends, and moves out again.
PortEnergy out_of_the_ramp(bool told) {
  Bounding bounding(contact_frame());
  SafetyStage stage({.ramp_up = 0.1});
  PortEnergy port(kDamping, kRotationalDamping, kPeriod);
  const Command spring{.elastic = Vec3(0, 0, 8.0)};
  Command held;
  for (int n = 0; n < 300; ++n) {
    const Vec3 displacement(0, 0, n >= 1 && n <= 10 ? -0.8e-3 : n >= 200 && n < 280 ? 1e-4 : 0.0);
    port.step(held, displacement, Vec3::Zero(), kPeriod);
    const Command bounded = bounding.step({displacement, Vec3::Zero(), kPeriod, spring}).rendered;
    held = stage
               .apply({.commanded = spring,
                       .bounded = bounded,
                       .displacement = displacement,
                       .hold_time = kPeriod})
               .rendered;
    if (told) bounding.set_held(held);
  }
  return port;
}

// If the bound does not get the held force, it counts work that was never done.
TEST(SafetyAttack, WhatWasWithheldCannotBeTakenBackLater) {
  EXPECT_EQ(out_of_the_ramp(true).violations(), 0u);
  const PortEnergy untold = out_of_the_ramp(false);
  EXPECT_GT(untold.violations(), 0u);
  EXPECT_LT(untold.least_margin(), -0.01);  // [J]
}

}  // namespace
}  // namespace feltwire::safety_attack_test

// Estimates the outside force from the movement that it causes.

#include "core/bounding/hand_force_bound.hpp"

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/bounding/account.hpp"
#include "tests/core/handle.hpp"

namespace feltwire::hand_force_bound_test {
namespace {

using namespace test;

constexpr double kPeriod = 1e-3;  // [s]
constexpr int kWindow = static_cast<int>(HandForceBound::kWindow / kPeriod);

PortKnowledge known(double quantum = 0.0) {
  PortKnowledge k;
  k.damping = 0.05;
  k.mass = 0.075;
  k.outside_force = 10.0;
  k.quantum = quantum;
  return k;
}

/// A handle without friction, and the outside force that the estimator learns from it.
struct Trial {
  PortKnowledge knowledge;
  HandForceBound learned{knowledge, kPeriod};
  Handle handle{.mass = knowledge.mass};
  Vec3 shown = Vec3::Zero();
  int sample = 0;

  /// `hand` and `held` give the forces [N] of each sample. Returns the bound at the end.
  template <class Hand, class Held>
  double after(int samples, const Hand& hand, const Held& held) {
    for (const int end = sample + samples; sample < end; ++sample) {
      handle.move(hand(sample) + held(sample), kPeriod);
      const Vec3 now = encoded(handle.position, knowledge.quantum);
      learned.moved(now - shown, held(sample), kPeriod);
      shown = now;
    }
    return learned.bound();
  }
};

Vec3 nothing(int) { return Vec3::Zero(); }

/// At 8 Hz a handle without friction stays near its position.
Vec3 swinging(int i) { return 4.0 * std::cos(2.0 * M_PI * 8e-3 * i) * Vec3(0.6, 0.0, 0.8); }

TEST(HandForceBound, IsTheLargestThatWasSeenAndAHalfMore) {
  Trial trial{known()};
  EXPECT_EQ(trial.learned.bound(), 10.0);
  // The second window is not complete yet.
  EXPECT_EQ(trial.after(2 * kWindow - 1, swinging, nothing), 10.0);
  // Two windows are complete. Over 16 samples the estimate keeps 0.987 of the peak of an 8 Hz
  // cosine.
  const double bound = trial.after(1, swinging, nothing);
  EXPECT_LT(bound, 1.5 * 4.0);
  EXPECT_GT(bound, 1.5 * 4.0 * 0.98);
}

/// The device's own force is no outside force, even if it changes with every sample.
TEST(HandForceBound, HeldForcesAreTakenOff) {
  const auto held = [](int i) {
    return Vec3(3.0 * ((i * 7919) % 13 - 6) / 6.0, i % 2 == 0 ? 2.0 : -2.0, 0.0);
  };
  Trial trial{known()};
  const double bound = trial.after(2 * kWindow, swinging, held);
  EXPECT_NEAR(bound, 1.5 * 4.0 * 0.99, 0.1);
}

/// The two end readings of a block have an error of at most q. For 30 um, 75 g and 8 ms, this is
/// 0.12 N.
TEST(HandForceBound, AnEncoderMakesItLargerNeverSmaller) {
  Trial exact{known()}, coarse{known(30e-6)};
  const double truth = exact.after(2 * kWindow, swinging, nothing);
  const double seen = coarse.after(2 * kWindow, swinging, nothing);
  EXPECT_GE(seen, truth);
  EXPECT_LE(seen - truth, 1.5 * 4.0 * std::sqrt(3.0) * 30e-6 * 0.075 / 64e-6);
}

TEST(HandForceBound, StaysBetweenAShareOfWhatWasToldAndAllOfIt) {
  Trial idle{known()}, strong{known()};
  EXPECT_EQ(idle.after(3 * kWindow, nothing, nothing), 2.5);
  const auto pull = [](int i) { return Vec3(5.0 * swinging(i)); };
  EXPECT_EQ(strong.after(3 * kWindow, pull, nothing), 10.0);
}

TEST(HandForceBound, AStrongerForceIsBelievedAtOnce) {
  Trial trial{known()};
  ASSERT_LT(trial.after(2 * kWindow, swinging, nothing), 6.0);
  trial.learned.exceeded();
  EXPECT_EQ(trial.learned.bound(), 10.0);
  EXPECT_EQ(trial.after(2 * kWindow - 1, swinging, nothing), 10.0);
  EXPECT_LT(trial.after(1, swinging, nothing), 6.0);
}

/// A sample with another duration starts new blocks. The estimator must not use incomplete blocks.
TEST(HandForceBound, SamplesOfOtherLengthsSayNothing) {
  HandForceBound learned(known(), kPeriod);
  // A jump occurs every 15 samples, but never in two complete blocks.
  for (int i = 0; i < 4 * kWindow; ++i)
    if (i % 15 == 0)
      learned.moved(Vec3(0.01, 0, 0), Vec3::Zero(), 3.0 * kPeriod);
    else
      learned.moved(Vec3::Zero(), Vec3::Zero(), kPeriod);
  EXPECT_EQ(learned.bound(), 2.5);
}

/// A calm hand lowers the account's estimate of the hand force. If the hand then pulls harder, the
/// hand may overdraw the account once at most. The declared force then applies again.
TEST(HandForceBound, TheAccountBelievesTheHandAndSeesWhereItWasWrong) {
  AccountConfig config;
  config.period = kPeriod;
  config.translation = known(30e-6);
  config.learns_outside_force = true;
  PortAccount account(config);
  EXPECT_EQ(account.outside_force(), 10.0);
  Handle handle{.mass = 0.075, .viscous = 0.05};
  Vec3 shown = Vec3::Zero();
  const auto run = [&](int samples, const auto& hand) {
    Command held;
    for (int i = 0; i < samples; ++i) {
      handle.move(held.force() + hand(i, held.force()), kPeriod);
      const Vec3 now = encoded(handle.position, 30e-6);
      const Command wanted{Vec3(-3.0 * (i % 40 < 20), 1.0, 0), Vec3::Zero(), Vec3::Zero()};
      held = account.step({.displacement = now - shown, .hold_time = kPeriod, .command = wanted});
      shown = now;
    }
  };
  run(3 * kWindow, [](int i, const Vec3&) { return Vec3(0.5 * swinging(i)); });
  EXPECT_LT(account.outside_force(), 5.0);
  EXPECT_EQ(account.statistics().strong_hand, 0u);
  EXPECT_GE(account.balance(), 0.0);
  // The hand pulls along the held force with its declared strength.
  run(kWindow / 2, [](int, const Vec3& held) {
    return Vec3(10.0 * (held.norm() > 0.0 ? Vec3(held.normalized()) : Vec3::UnitX()));
  });
  EXPECT_EQ(account.outside_force(), 10.0);
  EXPECT_GT(account.statistics().strong_hand, 0u);
  EXPECT_LE(account.statistics().overdrawn, 1u);
}

}  // namespace
}  // namespace feltwire::hand_force_bound_test

// A surface moves away from the robot's tool. Tests when the hand must lose its force.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/numeric.hpp"
#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/surface_offset.hpp"

namespace feltwire::lost_contact_test {
namespace {

constexpr double kPeriod = 1e-3;       // [s]
constexpr double kStiffness = 2000.0;  // [N/m] stiffness of the wall
constexpr double kDepth = 1e-3;        // [m] depth of the resting tool
constexpr double kLead = 5e-3;         // [m] distance of the hand ahead of the tool

/// A wall perpendicular to z. The tool enters along -z.
struct Bench {
  ContactEstimator estimate{{}};
  double wall = 0.0;         // [m] position of the wall
  Vec3 tip = Vec3(0, 0, 0);  // [m]
  SurfacePrior prior = {};
  std::optional<Vec3> force;  // [N] replaces the force of the wall

  const RemoteContact& step(const Vec3& velocity = Vec3::Zero()) {
    tip += kPeriod * velocity;
    const double depth = std::max(0.0, wall - tip.z());
    return estimate.step({.position = tip,
                          .velocity = velocity,
                          .force = force.value_or(Vec3(0, 0, kStiffness * depth)),
                          .elapsed = kPeriod,
                          .prior = prior});
  }
  /// Moves in from 1 mm in front of the wall, and rests for some time.
  void press() {
    constexpr double kSpeed = 0.02;  // [m/s]
    tip = Vec3(0, 0, wall + 1e-3);
    while (tip.z() > wall - kDepth) step(Vec3(0, 0, -kSpeed));
    for (int n = 0; n < 600; ++n) step();
  }
  /// Returns the force [N] on a hand ahead of the tool.
  double felt() const {
    const RemoteContact& seen = estimate.contact();
    if (seen.surface == 0) return 0.0;
    const Vec3 hand = tip - Vec3(0, 0, kLead);
    return seen.stiffness * std::max(0.0, (seen.point - hand).dot(seen.normal));
  }
};

/// F = k (d - v t) falls below `off` at t = (d - off / k) / v. The hand must lose its force kLeft
/// later.
TEST(LostContact, AWallThatLeavesIsNotFelt) {
  for (const double speed : {0.005, 0.02, 0.1}) {
    Bench bench;
    bench.press();
    const std::uint32_t surface = bench.estimate.contact().surface;
    const double place = bench.tip.z() + kDepth, depth = bench.wall - bench.tip.z();
    const double off = ContactEstimatorConfig{}.off;
    const double lost = (depth - off / kStiffness) / speed;
    for (double t = kPeriod; t < lost + 1.0; t += kPeriod) {
      bench.wall = place - speed * t;
      bench.step();
      const bool waits = t < lost + ContactEstimator::kLeft - 2.0 * kPeriod;
      const bool over = t > lost + ContactEstimator::kLeft + 2.0 * kPeriod;
      if (waits) {
        EXPECT_GT(bench.felt(), 1.0) << speed << ' ' << t;
      }
      if (over) {
        EXPECT_EQ(bench.felt(), 0.0) << speed << ' ' << t;
        EXPECT_FALSE(bench.estimate.contact().touching);
      }
      EXPECT_EQ(bench.estimate.contact().surface, surface) << "it keeps its number";
    }
  }
}

/// The tool follows its target into free space. Until then the estimate has the surface at its tip.
TEST(LostContact, AToolThatAdvancesIsFreeAtTheSameTime) {
  Bench bench;
  bench.press();
  bench.wall = -1.0;
  for (int n = 1; n < 100; ++n) {
    bench.step(Vec3(0, 0, -0.02));
    if (n * kPeriod > ContactEstimator::kLeft + kPeriod) {
      EXPECT_EQ(bench.felt(), 0.0) << n;
    }
  }
}

/// A resting surface has no force only after the tool has left it.
TEST(LostContact, AToolThatLeavesTheWallFindsItAgainAtOnce) {
  for (const double speed : {0.002, 0.02, 0.2})
    for (const double height : {0.1e-3, 3e-3}) {
      Bench bench;
      bench.press();
      while (bench.tip.z() < bench.wall + height) {
        bench.step(Vec3(0, 0, speed));
        EXPECT_GT(bench.felt(), 0.0) << "a hand ahead of the tool is inside";
      }
      for (int n = 0; n < 1000; ++n) bench.step();
      EXPECT_NEAR(bench.estimate.contact().point.z(), bench.wall, 2e-5);
      for (int n = 0; bench.tip.z() > bench.wall - kDepth; ++n) {
        bench.step(Vec3(0, 0, -speed));
        const double expected = kStiffness * (bench.wall - bench.tip.z() + kLead);
        EXPECT_NEAR(bench.felt(), expected, 0.02 * expected + 0.1) << speed << ' ' << n;
      }
    }
}

/// The estimated plane may be tilted. Sliding along it must not count as a loss of contact.
TEST(LostContact, AToolThatSlidesDownALeaningPlaneHasNotLostIt) {
  for (const double slope : {0.3, 0.7}) {
    Bench bench;
    bench.press();
    bench.force = Vec3::Zero();
    const Vec3 down = 0.03 * direction(Vec3(1.0, 0.0, -slope));
    for (int n = 0; n < 100; ++n) bench.step(down);
    EXPECT_EQ(bench.felt() == 0.0, slope > 0.5) << slope;
  }
}

/// A tool that bounces over a table must count as in contact all the time, at any depth.
TEST(LostContact, AForceThatIsMissingForAMomentIsNoLoss) {
  Bench bench;
  bench.press();
  for (int n = 0; n < 1000; ++n) {
    bench.force = n % 50 < 19 ? std::optional<Vec3>(Vec3::Zero()) : std::nullopt;
    bench.step();
    EXPECT_GT(bench.felt(), 10.0) << n;
  }
}

/// The wall returns at 30 mm/s to a tool that moves in at 10 mm/s. A fit of force over the tool's
/// movement would give four times the stiffness.
TEST(LostContact, AWallThatComesBackKeepsItsStiffnessAndItsNumber) {
  Bench bench;
  bench.press();
  const RemoteContact before = bench.estimate.contact();
  ASSERT_NEAR(before.stiffness, kStiffness, 2.0);
  bench.wall -= 4e-3;
  for (int n = 0; n < 200; ++n) bench.step();
  EXPECT_EQ(bench.felt(), 0.0);
  for (int n = 0; n < 150; ++n) {
    bench.wall += 0.03 * kPeriod;
    bench.step(Vec3(0, 0, -0.01));
  }
  const RemoteContact& seen = bench.estimate.contact();
  EXPECT_TRUE(seen.touching);
  EXPECT_EQ(seen.surface, before.surface);
  EXPECT_NEAR(seen.stiffness, kStiffness, 2.0);
  EXPECT_NEAR(seen.point.z(), bench.wall, 1e-3);
  EXPECT_GT(bench.felt(), 5.0);
}

TEST(LostContact, AModelThatWasTouchedIsNotBelievedWhereItsSurfaceHasLeft) {
  Bench bench;
  bench.prior = {.key = 7, .normal = Vec3::UnitZ(), .stiffness = 1500.0};
  bench.press();
  EXPECT_GT(bench.felt(), 5.0);
  bench.wall = -1.0;
  for (int n = 0; n < 100; ++n) bench.step();
  EXPECT_EQ(bench.felt(), 0.0);
  // The estimator must accept another surface of the model.
  bench.prior.key = 8;
  bench.prior.point.z() = bench.tip.z() - 1e-3;
  bench.step();
  EXPECT_GT(bench.felt(), 5.0);
}

/// The model's position may be too near. The tool then finds the surface farther on.
TEST(LostContact, AModelThatWasNeverTouchedGoesBackWithTheTool) {
  Bench bench;
  bench.wall = -1.0;
  bench.prior = {.key = 7, .normal = Vec3::UnitZ(), .stiffness = 1500.0};
  for (int n = 0; n < 500; ++n) {
    bench.step(Vec3(0, 0, -0.02));
    EXPECT_NEAR(bench.estimate.contact().point.z(), bench.tip.z(), 1e-12) << n;
  }
}

/// A wall that moves as its model predicts is still in contact.
TEST(LostContact, AModelThatMovesIsBelieved) {
  Bench bench;
  bench.prior = {.key = 7, .normal = Vec3::UnitZ(), .stiffness = kStiffness};
  bench.press();
  constexpr double kSpeed = 0.05;  // [m/s]
  bench.prior.velocity.z() = -kSpeed;
  for (int n = 0; n < 200; ++n) {
    bench.wall -= kSpeed * kPeriod;
    bench.prior.point.z() -= kSpeed * kPeriod;
    bench.step();
  }
  EXPECT_EQ(bench.estimate.contact().surface, 1u);
  EXPECT_NEAR(bench.estimate.contact().point.z(), bench.wall, 1e-3);
}

TEST(LostContact, WhatHasLeftIsNotRememberedBesideAnotherSurface) {
  Bench bench;
  bench.press();
  bench.wall = -1.0;
  for (int n = 0; n < 100; ++n) bench.step();
  bench.force = Vec3(2.0, 0.0, 0.0);
  bench.step();
  EXPECT_EQ(bench.estimate.contact().surface, 2u);
  EXPECT_EQ(bench.estimate.others().count, 0);
}

/// The offset of a hand still settles after a first touch. The offset must not treat the reported
/// position as a change.
TEST(LostContact, TheIndexStaysWhenASurfaceLeavesAndComesBack) {
  for (const int young : {20, 500}) {
    SurfaceOffset index;
    const Vec3 hand(0, 0, -kLead);
    RemoteContact seen{.surface = 1, .touching = true, .normal = Vec3::UnitZ(), .stiffness = 1e3};
    for (int n = 0; n < young; ++n) index.step(hand, Vec3::Zero(), seen, kPeriod);
    const Vec3 offset = index.offset();
    seen.touching = false;
    seen.point.z() = -ContactEstimator::kAway;
    for (int n = 0; n < 100; ++n) index.step(hand, Vec3::Zero(), seen, kPeriod);
    EXPECT_EQ(index.known_surface(), 1u);
    EXPECT_EQ(index.offset(), offset);
    seen.touching = true;
    seen.point.z() = -1e-3;
    for (int n = 0; n < 100; ++n) index.step(hand, Vec3::Zero(), seen, kPeriod);
    EXPECT_EQ(index.offset(), offset) << young;
  }
}

}  // namespace
}  // namespace feltwire::lost_contact_test

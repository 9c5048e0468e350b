// A prior is a surface that a model gives before the touch. Tests the position of the prior for the
// hand, its correction, and when the estimator rejects the prior.

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <numbers>

#include "core/teleoperation/contact_estimator.hpp"
#include "core/teleoperation/surface_offset.hpp"
#include "core/teleoperation/surface_tracker.hpp"

namespace feltwire::contact_prior_test {
namespace {

constexpr double kPeriod = 1e-3;  // [s]
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();

/// A floor at `place` [m]. The model assumes a floor at 0.
struct Floor {
  double place = 0.0, stiffness = 2000.0;
  SurfacePrior prior{.key = 7, .normal = Vec3::UnitZ(), .stiffness = 1500.0, .friction = 0.2};

  const RemoteContact& at(ContactEstimator& estimate, double height, double speed = 0.0) const {
    const double depth = std::max(0.0, place - height);
    return estimate.step({.position = Vec3(0, 0, height),
                          .velocity = Vec3(0, 0, speed),
                          .force = Vec3(0, 0, stiffness * depth),
                          .elapsed = kPeriod,
                          .prior = prior});
  }
  /// Moves from one height to another at a constant speed [m/s].
  const RemoteContact& go(ContactEstimator& estimate, double from, double to, double speed) const {
    const int steps = static_cast<int>(std::ceil(std::abs(to - from) / (speed * kPeriod)));
    for (int n = 1; n <= steps; ++n)
      at(estimate, from + (to - from) * n / steps, to > from ? speed : -speed);
    return estimate.contact();
  }
};

TEST(ContactPrior, TheSurfaceIsThereBeforeTheTouch) {
  ContactEstimator estimate({});
  const RemoteContact& seen = Floor{}.at(estimate, 0.05);
  EXPECT_EQ(seen.surface, 1u);
  EXPECT_FALSE(seen.touching);
  EXPECT_TRUE(seen.point.isZero(1e-15));
  EXPECT_EQ(seen.normal, Vec3::UnitZ());
  EXPECT_EQ(seen.stiffness, 1500.0);
  EXPECT_EQ(seen.friction, 0.2);
  EXPECT_TRUE(seen.velocity.isZero(0.0));
}

TEST(ContactPrior, ATouchIsOfTheSameSurfaceAndCorrectsItForTheNextOne) {
  for (const double wrong : {-3e-3, 3e-3}) {
    ContactEstimator estimate({});
    const Floor floor{.place = wrong};
    floor.go(estimate, 0.02, wrong - 3e-3, 0.05);
    for (int n = 0; n < 300; ++n) floor.at(estimate, wrong - 3e-3);
    EXPECT_EQ(estimate.contact().surface, 1u);
    EXPECT_TRUE(estimate.contact().touching);
    EXPECT_NEAR(estimate.contact().point.z(), wrong, 1e-5);
    EXPECT_NEAR(estimate.contact().stiffness, 2000.0, 20.0);
    floor.go(estimate, wrong - 3e-3, 0.1, 0.1);
    EXPECT_FALSE(estimate.contact().touching);
    EXPECT_EQ(estimate.contact().surface, 1u);
    EXPECT_NEAR(estimate.contact().point.z(), wrong, 1e-4) << "the model, as corrected";
    EXPECT_NEAR(estimate.contact().stiffness, 2000.0, 20.0);
  }
}

TEST(ContactPrior, AModelOfNothingRecedesAndIsNotBelieved) {
  ContactEstimator estimate({});
  const Floor nothing{.place = -1.0};
  nothing.go(estimate, 0.01, -0.5 * ContactEstimator::kSame, 0.05);
  EXPECT_EQ(estimate.contact().surface, 1u);
  EXPECT_LE(estimate.contact().point.z(), -0.5 * ContactEstimator::kSame + 1e-12);
  nothing.go(estimate, 0.0, -1.5 * ContactEstimator::kSame, 0.05);
  EXPECT_EQ(estimate.contact().surface, 0u);
  nothing.go(estimate, 0.0, 0.1, 0.05);
  EXPECT_EQ(estimate.contact().surface, 0u) << "nor where the tool has left";
  Floor other = nothing;
  other.prior.key = 8;
  EXPECT_EQ(other.at(estimate, 0.05).surface, 2u);
}

TEST(ContactPrior, WhatNoModelHasIsASurfaceOfItsOwn) {
  ContactEstimator estimate({});
  const Floor box{.place = 0.05};  // a box on the model's floor
  box.go(estimate, 0.07, 0.048, 0.05);
  const std::uint32_t found = estimate.contact().surface;
  EXPECT_EQ(found, 2u);
  EXPECT_NEAR(estimate.contact().point.z(), 0.05, 5e-4);
  box.go(estimate, 0.048, 0.06, 0.05);
  EXPECT_EQ(estimate.contact().surface, found) << "near it";
  box.go(estimate, 0.06, 0.12, 0.05);
  EXPECT_NEAR(estimate.contact().point.z(), 0.0, 1e-12) << "far from it the model counts";
}

TEST(ContactPrior, WhatIsNotFiniteOrUsableSaysNothing) {
  for (int which = 0; which < 4; ++which) {
    ContactEstimator estimate({.first_stiffness = 800.0});
    Floor floor;
    if (which == 0) floor.prior.point.z() = kNan;
    if (which == 1) floor.prior.normal.x() = kNan;
    if (which == 2) floor.prior.velocity.y() = kNan;
    if (which == 3) floor.prior.stiffness = floor.prior.friction = kNan;
    const RemoteContact& seen = floor.at(estimate, 0.05);
    EXPECT_EQ(seen.surface, which == 3 ? 1u : 0u) << which;
    if (which == 3) {
      EXPECT_EQ(seen.stiffness, 800.0);
      EXPECT_EQ(seen.friction, 0.0);
    }
  }
}

TEST(ContactPrior, TheIndexMovesWithTheTouchAndNotWithTheModel) {
  SurfaceOffset index;
  RemoteContact seen{.surface = 1,
                     .touching = false,
                     .point = Vec3::Zero(),
                     .normal = Vec3::UnitZ(),
                     .stiffness = 1500.0};
  Vec3 hand(0, 0, 0.01);
  for (int n = 0; n < 15; ++n) {
    hand.z() -= 1e-3;
    index.step(hand, Vec3(0, 0, -1e-3), seen, kPeriod);
  }
  EXPECT_TRUE(index.offset().isZero(0.0)) << "the surface is met where the model has it";
  EXPECT_EQ(index.known_surface(), 1u);
  seen.point.z() = 1e-4;  // The model moves.
  index.step(hand, Vec3::Zero(), seen, kPeriod);
  EXPECT_TRUE(index.offset().isZero(0.0));
  // The touch shows that the surface is 3 mm deeper. The hand must feel no step.
  seen.touching = true;
  seen.point.z() = -3e-3;
  index.step(hand, Vec3::Zero(), seen, kPeriod);
  EXPECT_NEAR(index.offset().z(), 3.1e-3, 1e-15);
  for (int n = 0; n < 150; ++n) index.step(hand, Vec3::Zero(), seen, kPeriod);
  seen.point.z() = -4e-3;  // After 0.1 s the hand must feel the moving surface.
  index.step(hand, Vec3::Zero(), seen, kPeriod);
  EXPECT_NEAR(index.offset().z(), 3.1e-3, 1e-15);
}

TEST(SurfaceTracker, StandsStillUntilItMovesAndThenHasNoLag) {
  SurfaceTracker place;
  place.begin(0.1, 0.1);
  double speed = 0.0;
  const auto noise = [](int n) { return n % 2 == 0 ? 5e-6 : -5e-6; };
  for (int n = 0; n < 1000; ++n) {
    place.step(0.1 + noise(n), kPeriod);
    speed = std::max(speed, std::abs(place.speed()));
  }
  EXPECT_EQ(speed, 0.0);
  constexpr double kSwing = 5e-3, kRate = 2.0 * std::numbers::pi;  // [m], [rad/s]
  double worst_place = 0.0, worst_speed = 0.0;
  for (int n = 1; n <= 3000; ++n) {
    const double t = n * kPeriod;
    place.step(0.1 + kSwing * std::sin(kRate * t) + noise(n), kPeriod);
    if (n < 1000) continue;
    worst_place =
        std::max(worst_place, std::abs(place.place() - 0.1 - kSwing * std::sin(kRate * t)));
    worst_speed =
        std::max(worst_speed, std::abs(place.speed() - kRate * kSwing * std::cos(kRate * t)));
  }
  EXPECT_LT(worst_place, 1e-4);
  EXPECT_LT(worst_speed, 0.1 * kRate * kSwing);
  // The oscillation stops.
  const double rest = 0.1 + kSwing * std::sin(kRate * 3.0);
  for (int n = 0; n < 2000; ++n) place.step(rest, kPeriod);
  EXPECT_NEAR(place.speed(), 0.0, 1e-9);
}

/// Many robots take 20 to 100 samples a second. The trackers must not swing there.
TEST(SurfaceTracker, IsStableAtEveryServoPeriod) {
  for (const double period : {1e-6, 1e-3, 0.01, 0.02, 0.05, 0.1, 0.5, 10.0}) {
    SurfaceTracker place;
    place.begin(0.1, 0.1);
    constexpr double kStep = 5e-3;  // [m]
    double farthest = 0.0, fastest = 0.0;
    for (int n = 0; n < 4000; ++n) {
      place.step(0.1 + kStep, period);
      farthest = std::max(farthest, std::abs(place.place() - 0.1));
      fastest = std::max(fastest, std::abs(place.speed()));
    }
    EXPECT_LT(farthest, 2.0 * kStep) << period;
    EXPECT_LT(fastest, 0.5) << period;
    if (period < 1e-3) continue;
    EXPECT_NEAR(place.place(), 0.1 + kStep, 1e-6) << period;
    EXPECT_NEAR(place.speed(), 0.0, 1e-6) << period;
  }
}

}  // namespace
}  // namespace feltwire::contact_prior_test

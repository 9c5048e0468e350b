// The tool slides slightly as it moves in and out, like the tool of an arm.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/teleoperation/contact_estimator.hpp"

namespace feltwire::second_touch_test {
namespace {

constexpr double kPeriod = 1e-3;                        // [s]
constexpr double kStiffness = 5000.0, kFriction = 0.3;  // stiffness and friction of the floor z = 0
constexpr double kAside = 0.3;  // lateral movement of the arm's tool per metre of depth

/// Moves the tool to this depth [m] and slightly sideways. Returns the estimate.
const RemoteContact& move(ContactEstimator& estimate, double depth, double speed) {
  const Vec3 tip(kAside * depth, 0.0, -depth);
  const Vec3 velocity(kAside * speed, 0.0, -speed);
  Vec3 force = Vec3::Zero();
  if (depth > 0.0) {
    force.z() = kStiffness * depth;
    force.x() = speed == 0.0 ? 0.0 : -std::copysign(kFriction * force.z(), velocity.x());
  }
  return estimate.step({tip, velocity, force, kPeriod});
}

/// Moves from 5 mm above the floor to 2 mm inside at this speed [m/s], rests, and moves out again.
/// `sees` gets the estimate after each sample.
template <typename See>
void touch(ContactEstimator& estimate, double speed, double rest, const See& sees) {
  constexpr double kAbove = 5e-3, kDepth = 2e-3;  // [m]
  const int way = static_cast<int>((kAbove + kDepth) / (speed * kPeriod));
  for (int n = 0; n < way; ++n) sees(move(estimate, n * speed * kPeriod - kAbove, speed));
  for (int n = 0; n * kPeriod < rest; ++n) sees(move(estimate, kDepth, 0.0));
  for (int n = 0; n < way; ++n) sees(move(estimate, kDepth - n * speed * kPeriod, -speed));
}

/// Friction tilts the first force of a touch. The tilt must not affect a surface that is already
/// known.
TEST(SecondTouch, KeepsTheNormalThatALongTouchHasShown) {
  ContactEstimator estimate({});
  touch(estimate, 0.03, 2.0, [](const RemoteContact&) {});
  const double before = estimate.contact().normal.z();
  const std::uint32_t surface = estimate.contact().surface;
  double least = 1.0;
  touch(estimate, 0.03, 0.0, [&](const RemoteContact& seen) {
    least = std::min(least, seen.normal.z());
    EXPECT_EQ(seen.surface, surface);
  });
  EXPECT_GT(before, 0.975) << "going out leans it a little";
  EXPECT_GT(least, before - 1e-3) << "a force that friction leans is at 0.958";
}

/// The surface springs back, and the tool moves out along the force without sliding. An earlier
/// version treated this movement as sliding, and the normal followed the tool.
TEST(SecondTouch, AToolThatIsPushedOutDoesNotTurnTheNormal) {
  ContactEstimator estimate({});
  for (int n = 0; n < 1000; ++n) move(estimate, 2e-3, 0.0);
  // The tool moves out and along the floor, at 27 degrees.
  double least = 1.0;
  for (int n = 0; n < 100; ++n) {
    const double u = n * kPeriod;
    const Vec3 tip(kAside * 2e-3 + 0.04 * u, 0.0, 0.02 * u - 2e-3);
    const Vec3 force(0.0, 0.0, -kStiffness * tip.z());
    least = std::min(least, estimate.step({tip, Vec3(0.04, 0, 0.02), force, kPeriod}).normal.z());
  }
  EXPECT_GT(least, 0.99);
}

/// Before the stiffness is known, a position from a wrong stiffness would move with the force.
TEST(SecondTouch, AStiffnessThatIsNotKnownYetIsNoMotionOfTheSurface) {
  ContactEstimator estimate({});
  double fastest = 0.0;
  // The tool hits the surface and recedes. The movement is too small for a fit while the force
  // falls by 10 N.
  for (int n = 0; n < 300; ++n) {
    const double force = 12.0 * std::exp(-n * kPeriod / 0.05);
    const double depth = force / 1e6;
    const RemoteContact& seen =
        estimate.step({Vec3(0, 0, -depth), Vec3::Zero(), Vec3(0, 0, force), kPeriod});
    if (seen.touching) fastest = std::max(fastest, length(seen.velocity));
  }
  EXPECT_LT(fastest, 1e-3) << "the tool did not move, and neither did the surface";
}

/// An arm that hits a surface sticks and springs back. Friction tilts the force to alternating
/// sides. In an earlier version the normal followed, and the hand's force jumped.
TEST(FirstTouch, AForceThatLeansToBothSidesDoesNotSwingTheNormal) {
  ContactEstimator estimate({});
  double most = -1.0, least = 1.0;
  for (int n = 0; n < 60; ++n) {
    const double normal_force = 3.0, side = kFriction * normal_force;
    const Vec3 force(n < 30 ? -side : side, 0.0, normal_force);
    const Vec3 tip(0.0, 0.0, -normal_force / kStiffness);
    const double lean = estimate.step({tip, Vec3::Zero(), force, kPeriod}).normal.x();
    most = std::max(most, lean);
    least = std::min(least, lean);
  }
  EXPECT_NEAR(least, -0.287, 0.01) << "the first force is all that is known";
  EXPECT_LT(most, 0.05) << "both sides cancel";
}

/// The tool vibrates at first, so the estimator learns the stiffness late. Position and stiffness
/// must then change together, without a jump of the force.
TEST(FirstTouch, AStiffnessThatIsLearntLateChangesNoForce) {
  ContactEstimator estimate({});
  Vec3 tip(0, 0, -0.5e-3);
  for (int n = 0; n < 100; ++n) {
    const bool even = n % 2 == 0;
    estimate.step({tip, Vec3::Zero(), Vec3(0, 0, even ? 2.0 : 3.0), kPeriod});
    tip.z() += even ? -0.05e-3 : 0.05e-3;
  }
  const double assumed = ContactEstimatorConfig{}.first_stiffness;
  ASSERT_EQ(estimate.contact().stiffness, assumed) << "nothing was learnt yet";
  constexpr double kIn = 5e-6;  // [m] in one sample
  double felt = 0.0;
  for (int n = 0; n < 1000 && estimate.contact().stiffness == assumed; ++n) {
    tip.z() -= kIn;
    felt = -kStiffness * tip.z();
    estimate.step({tip, Vec3(0, 0, -kIn / kPeriod), Vec3(0, 0, felt), kPeriod});
  }
  const RemoteContact& seen = estimate.contact();
  ASSERT_GT(seen.stiffness, 2.0 * assumed);
  EXPECT_NEAR(seen.stiffness * (seen.point - tip).dot(seen.normal), felt, 1e-3 * felt);
}

}  // namespace
}  // namespace feltwire::second_touch_test

// A force that is made at the device does not step.

#include "client/servo/rise_limit.hpp"

#include <gtest/gtest.h>

namespace feltwire::rise_limit_test {
namespace {

constexpr double kSlew = 100.0;  // [N/s]
constexpr double kTick = 1e-3;   // [s]

LocalModel floor_of(double stiffness) {
  LocalModel model;
  model.count = 1;
  model.patches[0].material.stiffness = stiffness;
  return model;
}

Command push(double newton) { return {.elastic = Vec3(0, 0, newton)}; }

double risen(RiseLimit& limit, double wanted, const LocalModel& model, double way) {
  return limit.apply(push(wanted), model, way, kTick).elastic.z();
}

TEST(RiseLimit, AHandThatRestsFeelsASlew) {
  RiseLimit limit(kSlew, kSlew);
  const LocalModel model = floor_of(1e4);
  for (int n = 1; n <= 40; ++n)
    EXPECT_NEAR(risen(limit, 4.0, model, 0.0), std::min(4.0, 0.1 * n), 1e-12);
}

TEST(RiseLimit, APressIntoTheSurfaceIsFeltWhole) {
  RiseLimit limit(kSlew, kSlew);
  const LocalModel model = floor_of(4e4);
  double depth = 0.0;
  for (const double way : {1e-6, 1e-4, 2e-4, 5e-5}) {
    depth += way;
    EXPECT_EQ(risen(limit, 4e4 * depth, model, way), 4e4 * depth);
  }
  // It may fall as it likes.
  EXPECT_EQ(risen(limit, 1.0, model, 0.0), 1.0);
  EXPECT_NEAR(risen(limit, 5.0, model, 0.0), 1.1, 1e-12);
}

TEST(RiseLimit, ASurfaceThatMovesAndADamperPushAHandThatRests) {
  LocalModel model = floor_of(1e3);
  model.patches[0].velocity = Vec3(0, 0, 0.1);
  RiseLimit limit(kSlew, kSlew);
  EXPECT_NEAR(risen(limit, 9.0, model, 0.0), 0.1 + 2.0 * 1e3 * 1e-4, 1e-12);
  model.patches[0].material.damping = 3.0;
  model.patches[0].material.viscous_friction = 2.0;
  RiseLimit damped(kSlew, kSlew);
  EXPECT_NEAR(risen(damped, 9.0, model, 0.0), 0.1 + 2.0 * 1e3 * 1e-4 + 5.0 * 0.1, 1e-12);
}

TEST(RiseLimit, ItGoesOnFromWhatIsOnTheHand) {
  RiseLimit limit(kSlew, kSlew);
  limit.given({.elastic = Vec3(0, 3, 0)});
  EXPECT_NEAR(risen(limit, 9.0, floor_of(1e3), 0.0), 3.1, 1e-12);
}

TEST(RiseLimit, TheDirectionStays) {
  RiseLimit limit(kSlew, kSlew);
  const Command command{.elastic = Vec3(3, 0, 4), .frictional = Vec3(0, 2, 0)};
  const Command given = limit.apply(command, floor_of(1e3), 0.0, kTick);
  EXPECT_NEAR(given.force().norm(), 0.1, 1e-12);
  EXPECT_NEAR(given.force().cross(command.force()).norm(), 0.0, 1e-12);
  EXPECT_NEAR(given.elastic.norm() / given.frictional.norm(), 2.5, 1e-12);
}

}  // namespace
}  // namespace feltwire::rise_limit_test

// A force that the client itself makes must not step.

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
  // The force may fall at any rate.
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

/// A tool with a radius of 50 mm on a spring of 1 N/mm and 2 N m/rad.
BodyModel body() {
  BodyModel model;
  model.coupling = {1000.0, 2.0, 8.0, 0.5};
  model.radius = 0.05;
  return model;
}

TEST(RiseLimit, ATorqueOfABodyIsLimitedAsItsForceIs) {
  constexpr double kTorqueSlew = 10.0;  // [N m/s]
  const Command command{.elastic = Vec3(0, 0, 8), .torque = Vec3(0, 0.5, 0)};
  RiseLimit rests(kSlew, kTorqueSlew);
  // The torque limit is lower: 0.5 N m takes 50 ms, and 8 N take 80 ms.
  for (int n = 1; n <= 100; ++n) {
    const Command given = rests.apply(command, body(), 0.0, 0.0, kTick);
    EXPECT_NEAR(given.force().norm(), std::min(8.0, 0.1 * n), 1e-9);
    // A common scale reduces force and torque.
    EXPECT_NEAR(given.torque.norm(), 0.5 * given.force().norm() / 8.0, 1e-9);
  }
  // A translation changes the torque by the spring's force times the radius. A rotation changes it
  // by the spring's torque.
  RiseLimit moves(kSlew, kTorqueSlew);
  EXPECT_NEAR(moves.apply({.torque = Vec3(1, 0, 0)}, body(), 1e-3, 0.0, kTick).torque.x(),
              0.01 + 2.0 * 1000.0 * 0.05 * 1e-3, 1e-9);
  RiseLimit turns(kSlew, kTorqueSlew);
  EXPECT_NEAR(turns.apply({.torque = Vec3(1, 0, 0)}, body(), 0.0, 1e-2, kTick).torque.x(),
              0.01 + 2.0 * 2.0 * 1e-2, 1e-9);
  RiseLimit swings(kSlew, kTorqueSlew);
  EXPECT_NEAR(swings.apply({.elastic = Vec3(9, 0, 0)}, body(), 0.0, 1e-3, kTick).force().x(),
              0.1 + 2.0 * 1000.0 * 0.05 * 1e-3, 1e-9);
}

TEST(RiseLimit, ADamperBesideTheSpringAddsItsForce) {
  ToolInertia inertia;
  inertia.mass = 0.1;
  inertia.damping = 20.0;
  inertia.rotational_damping = 0.03;
  RiseLimit limit(kSlew, 10.0);
  EXPECT_NEAR(
      limit.apply({.elastic = Vec3(9, 0, 0)}, body(), 1e-4, 0.0, kTick, &inertia).force().x(),
      0.1 + 2.0 * 1000.0 * 1e-4 + 20.0 * 1e-4 / kTick, 1e-9);
  RiseLimit turns(kSlew, 10.0);
  EXPECT_NEAR(turns.apply({.torque = Vec3(1, 0, 0)}, body(), 0.0, 1e-3, kTick, &inertia).torque.x(),
              0.01 + 2.0 * 2.0 * 1e-3 + 0.03 * 1e-3 / kTick, 1e-9);
}

TEST(RiseLimit, ASurfaceThatMovesTakesABodyWithIt) {
  BodyModel model = body();
  model.patches[0].velocity = Vec3(0, 0, 0.5);
  model.patch_count = 1;
  RiseLimit limit(kSlew, 10.0);
  EXPECT_NEAR(limit.apply({.elastic = Vec3(0, 0, 9)}, model, 0.0, 0.0, kTick).force().z(),
              0.1 + 2.0 * 1000.0 * 0.5 * kTick, 1e-9);
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

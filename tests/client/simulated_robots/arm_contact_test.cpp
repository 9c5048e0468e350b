// Compares the simulated arm in contact with objects with closed forms.

#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <string>

#include "core/teleoperation/contact_estimator.hpp"
#include "tests/client/simulated_robots/arm_support.hpp"

namespace feltwire::arm_test {
namespace {

constexpr double kTable = 5000.0, kHigh = 0.3;  // [N/m], [m] scenes/arm/table.xml
constexpr double kBox = 0.15;                   // [kg] scenes/arm/box.xml
constexpr double kGravity = 9.81;

double series(double a, double b) { return a * b / (a + b); }

ArmConfig closed(const std::string& name) {
  ArmConfig config = config_of(name);
  config.gripper = 0.0;
  return config;
}

/// The arm with closed fingers above the table.
struct AboveTheTable : Robot {
  explicit AboveTheTable(double height) : Robot(closed("table")) {
    move({0.45, 0.0, kHigh + height}, 2.0);
    wait(0.5);
  }
};

TEST(ArmContact, PressesWithTheSeriesStiffness) {
  for (const double stiffness : {500.0, 1000.0}) {
    ArmConfig config = closed("table");
    config.stiffness = stiffness;
    Robot run(config);
    run.move({0.45, 0.0, kHigh + 0.02}, 2.0);
    for (const double depth : {0.005, 0.01, 0.02}) {
      run.move({0.45, 0.0, kHigh - depth}, 1.0);
      run.wait(1.0);
      const Vec3 force = run.mean_force(0.5);
      EXPECT_NEAR(force.z(), series(stiffness, kTable) * depth, 0.02 * force.z())
          << stiffness << " N/m, " << depth << " m";
      EXPECT_LT(std::hypot(force.x(), force.y()), 0.3);  // Friction carries a part of the force.
      EXPECT_LT((force - run.arm.contact_force()).norm(), 0.02);
    }
  }
}

TEST(ArmContact, SlidesWithFriction) {
  AboveTheTable run(0.01);
  run.move({0.42, 0.0, kHigh - 0.012}, 1.0);
  run.move({0.52, 0.0, kHigh - 0.012}, 2.0);
  double sums = 0.0, normal = 0.0;
  for (int i = 0; i < 500; ++i) {
    run.target.pose.position.x() += 0.05 * kPeriod;
    run.tick();
    sums -= run.reading.force->x();
    normal += run.reading.force->z();
  }
  EXPECT_NEAR(sums / normal, 0.3, 0.01);
}

TEST(ArmContact, TheEstimateFindsTheTable) {
  AboveTheTable run(0.01);
  ContactEstimator estimate({.first_stiffness = run.arm.spec().stiffness});
  RemoteContact found;
  for (int i = 0; i < 4000; ++i) {
    const double u = std::min(1.0, i / 2000.0);
    run.target.pose.position.z() = kHigh + 0.01 - 0.022 * u;
    const FollowerReading& r = run.tick();
    found = estimate.step({r.pose.position, r.velocity, r.force.value_or(Vec3::Zero()), kPeriod});
  }
  EXPECT_TRUE(found.touching);
  EXPECT_GT(found.normal.z(), 0.999);
  EXPECT_NEAR(found.stiffness, kTable, 0.1 * kTable);
  EXPECT_NEAR(found.point.z(), kHigh, 3e-4);
}

TEST(ArmContact, ASpherePushesAlongItsNormal) {
  Robot run(closed("sphere"));
  const Vec3 centre(0.45, 0.0, 0.3);
  const Vec3 normal = Vec3(0.0, 0.3, 1.0).normalized();
  run.move(centre + 0.12 * normal, 2.0);
  run.move(centre + 0.09 * normal, 1.0);
  run.wait(0.5);
  const Vec3 force = run.mean_force(0.2);
  EXPECT_GT(force.norm(), 5.0);
  // The force is within the friction cone (mu 0.3), towards the free side.
  EXPECT_GT(force.normalized().dot(normal), std::cos(std::atan(0.3)) - 1e-3);
}

TEST(ArmContact, LiftsTheBoxAndFeelsItsWeight) {
  Robot run("box");
  const Vec3 at = run.arm.place_of("box").value_or(Vec3::Zero());
  run.move(at + Vec3(0.0, 0.0, 0.06), 2.0);
  run.move(at + Vec3(0.0, 0.0, 0.005), 1.0);
  run.wait(0.5);
  const Vec3 empty = run.mean_force(0.5);
  run.target.gripper = 0.03;  // 5 mm into each side: 20 N per finger
  run.wait(0.5);
  EXPECT_NEAR(run.reading.gripper, 0.04, 5e-4);
  EXPECT_NEAR(run.reading.gripper_force, 20.0, 1.5);
  run.move(at + Vec3(0.0, 0.0, 0.08), 1.5);
  run.wait(1.0);
  const Vec3 loaded = run.mean_force(0.5);
  EXPECT_NEAR(run.arm.place_of("box")->z(), at.z() + 0.075, 3e-3);
  EXPECT_NEAR((loaded - empty).z(), -kBox * kGravity, 0.02);
  // The weight stretches the spring.
  EXPECT_NEAR(run.target.pose.position.z() - run.reading.pose.position.z(),
              kBox * kGravity / run.arm.spec().stiffness, 5e-5);
  // After the release the box must fall.
  run.target.gripper = 0.08;
  run.wait(0.6);
  EXPECT_NEAR(run.arm.place_of("box")->z(), at.z(), 2e-3);
  EXPECT_LT(run.mean_force(0.5).norm(), 0.05);
}

TEST(ArmContact, TheGripperHoldsWithAtMostItsForce) {
  Robot run("box");
  const Vec3 at = run.arm.place_of("box").value_or(Vec3::Zero());
  run.move(at + Vec3(0.0, 0.0, 0.06), 2.0);
  run.move(at + Vec3(0.0, 0.0, 0.005), 1.0);
  run.target.gripper = 0.0;  // 20 mm into each side: 80 N without the limit
  run.wait(0.5);
  EXPECT_NEAR(run.reading.gripper_force, 40.0, 1e-9);
  EXPECT_GT(run.reading.gripper, 0.037);
}

/// The target moves straight down, 1 mm beside the axis. The compliance must move the peg into the
/// hole. The hole is 0.25 mm wider on each side.
TEST(ArmContact, ThePegGoesInByCompliance) {
  ArmConfig config = config_of("peg");
  config.gripper = 0.02;
  Robot run(config);
  run.target.gripper = 0.01;
  run.wait(0.3);
  const double top = 0.33;     // [m] top of the block
  const double beside = 1e-3;  // [m] distance from the axis
  const double below = 0.045;  // [m] distance of the peg's tip below the tool, approximately
  run.move({0.45 + beside, beside, top + below + 0.02}, 2.0);
  double peak = 0.0;
  for (int i = 0; i < 4000; ++i) {
    run.target.pose.position.z() -= i < 3000 ? 0.05 / 3000 : 0.0;
    peak = std::max(peak, run.tick().force->norm());
  }
  const Vec3 peg = run.arm.place_of("peg").value_or(Vec3::Zero());
  const double tip = peg.z() - 0.04;
  EXPECT_LT(tip, top - 0.015) << "the peg did not go in";
  EXPECT_LT(std::hypot(peg.x() - 0.45, peg.y()), 0.75e-3);
  EXPECT_LT(peak, 15.0);
  EXPECT_FALSE(run.reading.stopped);
}

}  // namespace
}  // namespace feltwire::arm_test

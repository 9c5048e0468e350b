// Compares a point shell against solids with closed forms, with a sum over all points, and with
// skipped points.

#include "core/point_shell/shell_contact.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/bodies.hpp"
#include "tests/core/support.hpp"

namespace feltwire::shell_contact_test {
namespace {

using test::box_shell;
using test::flat_force;
using test::grid_of;
using test::kFace;
using test::kHalf;
using test::kRound;
using test::kStiffness;
using test::object;

ShellContact contact(const PointShell& shell, const Pose& pose, const Object& o, double area) {
  ShellContact sum;
  add_contact(shell, pose, o, area, sum);
  return sum;
}

TEST(ShellContact, ABoxFlatOnAPlane) {
  constexpr double kDepth = 2e-3;
  const Object plane = object(Plane{});
  const double force = flat_force(kDepth, kFace);
  for (const std::size_t count : {100u, 1000u, 10000u}) {
    const PointShell shell = box_shell(count);
    const ShellContact c =
        contact(shell, {Vec3(0.1, 0.2, 0.01 - kDepth), Quaternion::Identity()}, plane, kFace);
    // distance between neighbours, as a fraction of the face's width
    const double share = 1.0 / std::sqrt(static_cast<double>(count));
    EXPECT_NEAR(c.wrench[2], force, 0.5 * share * force) << count;
    EXPECT_EQ(c.wrench.head<2>(), Eigen::Vector2d::Zero());
    EXPECT_NEAR(c.wrench[3], 0.0, 0.02 * share * force) << count;
    EXPECT_NEAR(c.wrench[4], 0.0, 0.03 * share * force) << count;
    const double energy =
        kStiffness / kFace * (kFace * kDepth * kDepth / 2.0 + kRound * std::pow(kDepth, 3) / 6.0);
    EXPECT_NEAR(c.energy, energy, 0.5 * share * energy) << count;
  }
}

/// The points of the sides count too. Compared with the face alone, the force is larger by P d / (2
/// A): 8 % at 2 mm and 17 % at 4 mm for this box (docs/scenes.md, "Points or polygons").
TEST(ShellContact, ThePointsOfTheSidesCount) {
  const PointShell shell = box_shell(10000);
  for (const double depth : {1e-3, 2e-3, 3e-3, 4e-3}) {
    const ShellContact c =
        contact(shell, {Vec3(0, 0, 0.01 - depth), Quaternion::Identity()}, object(Plane{}), kFace);
    EXPECT_NEAR(c.wrench[2] / (kStiffness * depth), 1.0 + kRound * depth / (2.0 * kFace), 1e-3)
        << depth;
  }
}

// A box is rotated by a small angle about y. The depth is d + x sin a and the torque is k Iy sin a
// / A_c, with the second moment of area Iy of the face.
TEST(ShellContact, ABoxTurnedOnAPlane) {
  constexpr double a = 0.03, angle = 1e-3, d = 2e-4;
  const PointShell shell = box_shell(40000);
  const ShellContact c =
      contact(shell, {Vec3(0, 0, 0.01 - d), Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()))},
              object(Plane{}), kFace);
  // This formula is of first order in the angle and includes the sides.
  const double second =
      0.04 * std::pow(2.0 * a, 3) / 12.0 + d * (0.08 * a * a + 4.0 / 3.0 * a * a * a);
  const double torque = kStiffness / kFace * second * angle;
  EXPECT_NEAR(c.wrench[4], -torque, 0.01 * torque);
  EXPECT_NEAR(c.wrench[2], flat_force(d, kFace), 0.01 * flat_force(d, kFace));
}

// The contact is off the box's centre and must give a torque.
TEST(ShellContact, TheForceActsWhereThePointsAre) {
  const double area = kFace;
  const PointShell shell = box_shell(20000);
  // Only the part x > 0 of the bottom rests on the step.
  const Object step = object(Box{Vec3(0.05, 0.05, 0.05)}, Vec3(0.05, 0, -0.05));
  const ShellContact c =
      contact(shell, {Vec3(0, 0, 0.01 - 1e-4), Quaternion::Identity()}, step, area);
  EXPECT_NEAR(c.wrench[2], 0.5 * kStiffness * 1e-4, 0.03 * kStiffness * 1e-4);
  EXPECT_NEAR(c.wrench[4], -0.015 * c.wrench[2], 0.02 * 0.015 * c.wrench[2]);
}

TEST(ShellContact, TheWrenchIsTheEnergysGradientAndTheStiffnessItsSecond) {
  const PointShell shell = box_shell(500);
  const double area = shell.area;
  const Object ball = object(grid_of(Sphere{0.03}, 1e-3), Vec3(0.1, -0.2, 0.3));
  const Pose pose = moved({ball.pose.position + Vec3(0.005, -0.01, 0.036), Quaternion::Identity()},
                          Vec3::Zero(), Vec3(0.3, -0.2, 0.5));
  const ShellContact c = contact(shell, pose, ball, area);
  ASSERT_GT(c.touching, 5u);
  constexpr double kStep = 1e-5;
  for (int i = 0; i < 6; ++i) {
    Vec6 by = Vec6::Zero();
    by[i] = kStep;
    const ShellContact up = contact(shell, moved(pose, by.head<3>(), by.tail<3>()), ball, area);
    const ShellContact down = contact(shell, moved(pose, -by.head<3>(), -by.tail<3>()), ball, area);
    const double scale = i < 3 ? 1.0 : 0.03;
    EXPECT_NEAR(c.wrench[i], -(up.energy - down.energy) / (2.0 * kStep),
                3e-4 * c.wrench.head<3>().norm() * scale);
    // The Gauss-Newton part omits the curvature of the field. The error grows with depth over
    // radius.
    EXPECT_NEAR(c.stiffness(i, i), -(up.wrench[i] - down.wrench[i]) / (2.0 * kStep),
                0.25 * c.stiffness.diagonal().head<3>().sum() * scale * scale);
  }
  EXPECT_LT((c.stiffness - c.stiffness.transpose()).norm(), 1e-9 * c.stiffness.norm());
}

/// Sums over all points, without the tree and groups.
ShellContact brute_force(const PointShell& shell, const Pose& pose, const Object& o, double area) {
  ShellContact sum;
  const double scale =
      o.material.stiffness * shell.area / (area * static_cast<double>(shell.points.size()));
  for (const Vec3& p : shell.points) {
    const Vec3 arm = pose.orientation * p;
    const Quaternion& turned = o.pose.orientation;
    const FieldPoint field = signed_distance(
        o.shape, o.felt_from, turned.conjugate() * (pose.position + arm - o.pose.position));
    if (!(field.distance < 0.0)) {
      sum.clearance = std::min(sum.clearance, field.distance);
      continue;
    }
    const Vec3 way = turned * field.gradient;
    Vec6 six;
    six << way, arm.cross(way);
    sum.energy += 0.5 * scale * field.distance * field.distance;
    sum.wrench -= scale * field.distance * six;
    sum.stiffness += scale * six * six.transpose();
    ++sum.touching;
  }
  return sum;
}

TEST(ShellContact, IsThatOfEveryPointAlone) {
  const PointShell shell = box_shell(1003);
  const std::vector<Shape> shapes = {Plane{},
                                     Sphere{0.03},
                                     Box{Vec3(0.03, 0.03, 0.03)},
                                     Capsule{0.02, 0.02},
                                     Cylinder{0.02, 0.03},
                                     grid_of(Sphere{0.03}, 1e-3),
                                     grid_of(Box{Vec3(0.02, 0.03, 0.04)}, 2e-3)};
  test::Random random(7);
  std::size_t touching = 0;
  for (const Shape& shape : shapes)
    for (const Side side : {Side::outside, Side::inside})
      for (int i = 0; i < 20; ++i) {
        Object o = object(shape, random.vector(-3.0, -1.0));
        o.felt_from = side;
        o.pose.orientation =
            Quaternion(Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()));
        const Pose pose{o.pose.position + random.uniform(0.0, 0.06) * random.direction(),
                        Quaternion(Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()))};
        const ShellContact all = brute_force(shell, pose, o, 1e-3);
        const ShellContact felt = contact(shell, pose, o, 1e-3);
        // A grid uses float. A point within the rounding error of the surface may touch or not.
        const bool grid = std::holds_alternative<Grid>(shape);
        const double close = grid ? 1e-5 : 1e-12, size = all.wrench.norm();
        EXPECT_NEAR(static_cast<double>(felt.touching), static_cast<double>(all.touching),
                    grid ? 1.0 : 0.0);
        EXPECT_NEAR(felt.energy, all.energy, close * all.energy);
        EXPECT_LE((felt.wrench - all.wrench).norm(), close * size);
        EXPECT_LE(
            (felt.stiffness - all.stiffness).norm(),
            (grid ? 2.0 / static_cast<double>(all.touching + 1) : close) * all.stiffness.norm());
        EXPECT_LE(felt.clearance, all.clearance + 1e-7);
        touching += felt.touching;
      }
  EXPECT_GT(touching, 10'000u);
}

TEST(ShellContact, FarPointsCostNothing) {
  const PointShell shell = box_shell(10000);
  for (const Shape& shape : {Shape(Plane{}), Shape(grid_of(Box{Vec3(0.1, 0.1, 0.02)}, 1e-3))}) {
    const Object o = object(shape);
    const double top = std::holds_alternative<Plane>(shape) ? 0.0 : 0.02;
    const auto looked = [&](double gap) {
      return contact(shell, {Vec3(0, 0, top + 0.01 + gap), Quaternion::Identity()}, o, 1e-3)
          .looked_at;
    };
    EXPECT_EQ(looked(0.1), 1u);
    EXPECT_LE(looked(0.05), 1u);
    EXPECT_LT(looked(0.005), 500u);
    const ShellContact touching =
        contact(shell, {Vec3(0, 0, top + 0.01 - 1e-4), Quaternion::Identity()}, o, 1e-3);
    EXPECT_GT(touching.touching, 2500u);   // the complete face
    EXPECT_LT(touching.looked_at, 6000u);  // few other points
  }
}

TEST(ShellContact, TheClearanceIsNoLie) {
  const PointShell shell = box_shell(1000);
  const Object ball = object(grid_of(Sphere{0.03}, 1e-3));
  test::Random random(1);
  for (int i = 0; i < 200; ++i) {
    const Pose pose{random.uniform(0.04, 0.2) * random.direction(),
                    Quaternion(Eigen::AngleAxisd(random.uniform(-3, 3), random.direction()))};
    double nearest = 1.0;
    for (const Vec3& p : shell.points) {
      const double d = (pose.position + pose.orientation * p).norm() - 0.03;
      if (d > 0.0) nearest = std::min(nearest, d);
    }
    EXPECT_LE(contact(shell, pose, ball, 1e-3).clearance, nearest + 1e-6);
  }
}

}  // namespace
}  // namespace feltwire::shell_contact_test

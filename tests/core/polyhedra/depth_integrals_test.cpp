// Compares the integrals of depth with closed forms, differences and sums over points.

#include "core/polyhedra/depth_integrals.hpp"

#include <gtest/gtest.h>

#include <Eigen/Eigenvalues>
#include <cmath>

#include "core/tool_coupling/tool_coupling.hpp"
#include "tests/core/polyhedra/solids.hpp"

namespace feltwire::depth_integrals_test {
namespace {

using test::box_corners;
using test::one_part;
using test::random_solid;

DepthSums sums_of(const Polyhedron& tool, const Pose& pose, const SolidParts& solid,
                  const Vec3* away = nullptr) {
  DepthSums sums;
  const Mat3 rotation = pose.orientation.toRotationMatrix();
  for (const SolidPart& part : solid.parts)
    add_depth({tool, rotation, pose.position}, part, solid.hollow, away, true, sums);
  return sums;
}

const Vec3 kHalf(0.03, 0.02, 0.01);
constexpr double kFace = 4.0 * 0.03 * 0.02;  // [m^2]
const Quaternion kUpright = Quaternion::Identity();

Quaternion about(const Vec3& axis, double angle) {
  return Quaternion(Eigen::AngleAxisd(angle, axis));
}

TEST(DepthIntegrals, ABoxFlatOnABox) {
  const SolidParts table = solid_parts(Box{Vec3(0.1, 0.1, 0.05)}, Side::outside);
  const Polyhedron box = polyhedron(box_corners(kHalf));
  for (const double h : {1e-6, 1e-4, 2e-3}) {
    const DepthSums sums = sums_of(box, {Vec3(0.01, 0.02, 0.06 - h), kUpright}, table);
    const double cubes = kFace * std::pow(h, 4) / 4.0;
    EXPECT_NEAR(sums.cubes, cubes, 1e-9 * cubes);
    Vec6 slope = Vec6::Zero();
    slope[2] = -kFace * std::pow(h, 3);
    EXPECT_LT((sums.slope - slope).norm(), 1e-9 * slope.norm());
    EXPECT_NEAR(sums.curvature(2, 2), 3.0 * kFace * h * h, 1e-9 * sums.curvature(2, 2));
    EXPECT_EQ(sums.cells, 1u);
  }
}

// An edge of 90 degrees is rotated by theta. Below the plane is a triangle of width (tan + cot)
// height.
TEST(DepthIntegrals, AnEdgeAndACornerOnAPlane) {
  const SolidParts plane = solid_parts(Plane{}, Side::outside);
  const Polyhedron box = polyhedron(box_corners(kHalf));
  for (const double theta : {0.2, 0.6, 1.2}) {
    const double reach = 0.03 * std::sin(theta) + 0.01 * std::cos(theta), h = 1e-3;
    const DepthSums sums =
        sums_of(box, {Vec3(0, 0, reach - h), about(Vec3::UnitY(), theta)}, plane);
    const double cubes = 0.04 * (std::tan(theta) + 1.0 / std::tan(theta)) * std::pow(h, 5) / 20.0;
    EXPECT_NEAR(sums.cubes, cubes, 1e-9 * cubes) << theta;
    EXPECT_NEAR(sums.slope[2], -5.0 * cubes / h, 1e-9 * 5.0 * cubes / h) << theta;
  }
  // A cube stands on its corner. Its section has the area 3 sqrt(3) / 2 t^2.
  const Polyhedron cube = polyhedron(box_corners(Vec3::Constant(0.01)));
  const Quaternion on_corner =
      Quaternion::FromTwoVectors(Vec3(1, 1, 1).normalized(), -Vec3::UnitZ());
  const double h = 2e-3, reach = 0.01 * std::sqrt(3.0);
  const DepthSums sums = sums_of(cube, {Vec3(0.3, 0, reach - h), on_corner}, plane);
  const double cubes = 1.5 * std::sqrt(3.0) * std::pow(h, 6) / 60.0;
  EXPECT_NEAR(sums.cubes, cubes, 1e-9 * cubes);
  EXPECT_NEAR(sums.slope[2], -6.0 * cubes / h, 1e-9 * 6.0 * cubes / h);
  EXPECT_LT(sums.slope.head<2>().norm() + sums.slope.tail<3>().norm() / 0.01,
            1e-9 * sums.slope.norm());
}

// A box is tilted about y, and its complete lower face is below the plane. At x in its frame, the
// face has the depth D = h - c (1 - cos) + x sin. The column above gives D^4 / (4 cos).
TEST(DepthIntegrals, ATiltedFaceHasItsTorque) {
  const SolidParts plane = solid_parts(Plane{}, Side::outside);
  const Polyhedron box = polyhedron(box_corners(kHalf));
  constexpr double h = 1e-3, a = 0.03, c = 0.01;
  const auto cubes = [&](double angle) {
    const double middle = h - c * (1.0 - std::cos(angle)), side = a * std::sin(angle);
    return 0.04 / (4.0 * std::cos(angle)) *
           (std::pow(middle + side, 5) - std::pow(middle - side, 5)) / (5.0 * std::sin(angle));
  };
  for (const double angle : {0.002, 0.01, 0.03}) {
    const DepthSums sums = sums_of(box, {Vec3(0, 0, c - h), about(Vec3::UnitY(), angle)}, plane);
    EXPECT_NEAR(sums.cubes, cubes(angle), 1e-9 * sums.cubes) << angle;
    const double step = 1e-4 * angle;
    const double torque = (cubes(angle + step) - cubes(angle - step)) / (2.0 * step);
    EXPECT_NEAR(sums.slope[4], torque, 1e-6 * torque) << angle;
  }
}

/// Returns the sum over the points of a lattice.
double brute_force(const Polyhedron& tool, const Pose& pose, const SolidPart& solid, int steps) {
  const Vec3 size = (solid.shape.most - solid.shape.least) / steps;
  double sum = 0.0;
  for (int i = 0; i < steps; ++i)
    for (int j = 0; j < steps; ++j)
      for (int k = 0; k < steps; ++k) {
        const Vec3 x = solid.shape.least + size.cwiseProduct(Vec3(i + 0.5, j + 0.5, k + 0.5));
        double depth = 1.0;
        for (const HalfSpaceBelow& plane : solid.shape.planes)
          depth = std::min(depth, plane.offset - plane.normal.dot(x));
        if (depth <= 0.0) continue;
        const Vec3 own = pose.orientation.conjugate() * (x - pose.position);
        bool in = true;
        for (const HalfSpaceBelow& plane : tool.planes)
          in = in && plane.normal.dot(own) <= plane.offset;
        if (in) sum += depth * depth * depth * size.prod();
      }
  return sum;
}

TEST(DepthIntegrals, AreThoseOfAllPoints) {
#ifdef FELTWIRE_SANITIZED
  constexpr int kSolids = 2, kSteps = 60;
  constexpr double kClose = 2e-2;
#else
  constexpr int kSolids = 6, kSteps = 120;
  constexpr double kClose = 5e-3;
#endif
  test::Random random(5);
  for (int i = 0; i < kSolids; ++i) {
    const Polyhedron tool = random_solid(random, 0.03);
    SolidParts solid = one_part(random_solid(random, 0.04));
    const Pose pose{0.03 * random.direction(), about(random.direction(), random.uniform(-3, 3))};
    const double all = brute_force(tool, pose, solid.parts[0], kSteps);
    ASSERT_GT(all, 0.0);
    EXPECT_NEAR(sums_of(tool, pose, solid).cubes, all, kClose * all);
  }
}

/// Compares the slope with central differences of V, at poses around the solid.
void expect_slope(const Polyhedron& tool, const SolidParts& solid, const Vec3* away,
                  double distance, std::uint64_t seed) {
  test::Random random(seed);
  int touching = 0;
  for (int i = 0; i < 60; ++i) {
    const Pose pose{distance * random.uniform(0.3, 1.0) * random.direction(),
                    about(random.direction(), random.uniform(-3, 3))};
    const DepthSums sums = sums_of(tool, pose, solid, away);
    // The depth is too small: the differences consist of rounding errors.
    if (!(sums.cubes > 1e-24)) continue;
    ++touching;
    Vec6 differences;
    constexpr double kStep = 1e-6;
    for (int k = 0; k < 6; ++k) {
      Vec6 by = Vec6::Zero();
      by[k] = k < 3 ? kStep * 0.02 : kStep;
      const double up = sums_of(tool, moved(pose, by.head<3>(), by.tail<3>()), solid, away).cubes;
      const double down =
          sums_of(tool, moved(pose, -by.head<3>(), -by.tail<3>()), solid, away).cubes;
      differences[k] = (up - down) / (2.0 * by[k]);
    }
    differences.tail<3>() /= 0.02;
    Vec6 slope = sums.slope;
    slope.tail<3>() /= 0.02;
    EXPECT_LT((slope - differences).norm(), 2e-5 * slope.norm() + 1e-4 * sums.cubes / 0.02) << i;
    // The stiffness must be positive and symmetric.
    const Mat6 h = sums.curvature - sums.pushed * sums.pushed.transpose() / (2.0 * sums.cubes);
    EXPECT_LT((h - h.transpose()).norm(), 1e-9 * h.norm());
    const double least = Eigen::SelfAdjointEigenSolver<Mat6>(h).eigenvalues()[0];
    EXPECT_GT(least, -1e-9 * h.norm());
  }
  EXPECT_GT(touching, 10);
}

TEST(DepthIntegrals, TheSlopeIsThatOfTheSum) {
  test::Random random(6);
  const Polyhedron tool = random_solid(random, 0.03);
  const SolidParts solid = one_part(random_solid(random, 0.04));
  expect_slope(tool, solid, nullptr, 0.06, 1);
  const Vec3 away = Vec3(0.3, -0.2, 0.9).normalized();
  expect_slope(tool, solid, &away, 0.06, 2);
  expect_slope(polyhedron(box_corners(kHalf)),
               solid_parts(Box{Vec3(0.03, 0.02, 0.04)}, Side::inside), nullptr, 0.03, 3);
  expect_slope(tool, solid_parts(Cylinder{0.02, 0.03}, Side::outside), nullptr, 0.05, 4);
  // Two bars form an angle. No part may use the faces of the other part.
  const SolidParts angle = solid_parts({box_corners(Vec3(0.03, 0.02, 0.01)),
                                        box_corners(Vec3(0.01, 0.02, 0.02), Vec3(-0.02, 0, 0.03))});
  expect_slope(tool, angle, nullptr, 0.06, 5);
}

/// Checks that the slope changes by H - R when the tool moves along each axis, including the
/// ridges.
void expect_curvature(const Polyhedron& tool, const SolidParts& solid, double reach, int seed) {
  test::Random random(seed);
  int touching = 0;
  double ridges = 0.0;
  for (int i = 0; i < 30; ++i) {
    const Pose pose{reach * random.uniform(0.3, 1.0) * random.direction(),
                    about(random.direction(), random.uniform(-3, 3))};
    const DepthSums sums = sums_of(tool, pose, solid);
    if (!(sums.cubes > 1e-14)) continue;
    ++touching;
    ridges = std::max(ridges, sums.ridges.norm() / sums.curvature.norm());
    EXPECT_LT((sums.ridges - sums.ridges.transpose()).norm(), 1e-12 * sums.curvature.norm());
    for (Eigen::Index axis = 0; axis < 3; ++axis) {
      constexpr double kWay = 1e-7;
      const auto slope = [&](double way) {
        return sums_of(tool, {pose.position + way * Vec3::Unit(axis), pose.orientation}, solid)
            .slope;
      };
      const Vec6 change = (slope(kWay) - slope(-kWay)) / (2.0 * kWay);
      const Vec6 law = (sums.curvature - sums.ridges).col(axis);
      EXPECT_LT((change - law).norm(), 1e-4 * sums.curvature.norm()) << i << ' ' << axis;
    }
  }
  EXPECT_GT(touching, 10);
  EXPECT_GT(ridges, 0.1);  // The ridges are large enough to reveal their omission.
}

TEST(DepthIntegrals, TheCurvatureIsTheSlopesChange) {
  test::Random random(8);
  const Polyhedron tool = random_solid(random, 0.03);
  const SolidParts solid = one_part(random_solid(random, 0.04));
  expect_curvature(tool, solid, 0.05, 1);
  expect_curvature(polyhedron(box_corners(kHalf)),
                   solid_parts(Box{Vec3(0.03, 0.02, 0.04)}, Side::inside), 0.03, 2);
  expect_curvature(tool, solid_parts(Cylinder{0.02, 0.03}, Side::outside), 0.045, 3);
}

TEST(DepthIntegrals, ASolidInTwoPiecesIsTheSolid) {
  const SolidParts whole = solid_parts(Box{Vec3(0.04, 0.04, 0.01)}, Side::outside);
  const SolidParts pieces = solid_parts({box_corners(Vec3(0.015, 0.04, 0.01), Vec3(-0.025, 0, 0)),
                                         box_corners(Vec3(0.025, 0.04, 0.01), Vec3(0.015, 0, 0))});
  const SolidParts slices = solid_parts({box_corners(Vec3(0.04, 0.04, 0.002), Vec3(0, 0, 0.008)),
                                         box_corners(Vec3(0.04, 0.04, 0.008), Vec3(0, 0, -0.002))});
  test::Random random(9);
  const Polyhedron tool = random_solid(random, 0.02);
  for (int i = 0; i < 40; ++i) {
    const Pose pose{
        Vec3(random.uniform(-0.05, 0.05), random.uniform(-0.05, 0.05), random.uniform(0.01, 0.03)),
        about(random.direction(), random.uniform(-3, 3))};
    const DepthSums one = sums_of(tool, pose, whole);
    for (const SolidParts* parts : {&pieces, &slices}) {
      const DepthSums two = sums_of(tool, pose, *parts);
      EXPECT_NEAR(two.cubes, one.cubes, 1e-9 * one.cubes) << i;
      EXPECT_LE((two.slope - one.slope).norm(), 1e-9 * one.slope.norm()) << i;
    }
  }
}

// All faces touch a ball of radius r. Each cell is then a pyramid with its apex in the centre: V =
// r^4 / 60 of the surface.
TEST(DepthIntegrals, OfManyFacesRoundABall) {
  constexpr double kRadius = 0.02;
  const Polyhedron tool = polyhedron(box_corners(Vec3::Constant(0.05)));
  for (const int faces : {6, 30, 63, 64, 65, 150}) {
    test::Random random(7);
    ClippedPolyhedron round;
    round.assign(tool, Mat3::Identity(), Vec3::Zero());
    for (const Vec3& way : {Vec3(1, 0, 0), Vec3(0, 1, 0), Vec3(0, 0, 1)})
      for (const double side : {-1.0, 1.0}) ASSERT_TRUE(round.cut(side * way, kRadius, 0));
    for (int i = 6; i < faces; ++i) ASSERT_TRUE(round.cut(random.direction(), kRadius, 0));
    std::vector<Vec3> corners;
    for (std::size_t c = 0; c < round.corner_count(); ++c) corners.push_back(round.corner(c));
    SolidParts solid = one_part(polyhedron(corners));
    Polyhedron& shape = solid.parts[0].shape;
    double area = 0.0;
    for (std::size_t f = 0; f < shape.planes.size(); ++f) {
      const auto loop = shape.face(f);
      for (std::size_t k = 2; k < loop.size(); ++k) {
        const Vec3& a = shape.vertices[loop[0]];
        area += 0.5 * (shape.vertices[loop[k - 1]] - a).cross(shape.vertices[loop[k]] - a).norm();
      }
    }
    const DepthSums sums = sums_of(tool, {Vec3(0.002, 0.001, 0), kUpright}, solid);
    EXPECT_NEAR(sums.cubes, std::pow(kRadius, 4) * area / 60.0, 1e-9 * sums.cubes) << faces;
    EXPECT_EQ(sums.cells, shape.planes.size());
    EXPECT_LT(sums.slope.head<3>().norm(), 1e-9 * sums.cubes / kRadius);
  }
}

TEST(DepthIntegrals, AThinWallIsAsDeepAsItsSurfaceIsFar) {
  const SolidParts wall = solid_parts(Box{Vec3(0.05, 0.05, 1e-4)}, Side::outside);
  const Polyhedron tool = polyhedron(box_corners(Vec3::Constant(0.005)));
  const Vec3 up = Vec3::UnitZ();
  for (const double h : {1e-5, 1e-4, 1e-3, 4e-3}) {
    const Pose pose{Vec3(0, 0, 1e-4 + 0.005 - h), kUpright};
    const double cubes = 1e-4 * std::pow(h, 4) / 4.0;
    EXPECT_NEAR(sums_of(tool, pose, wall, &up).cubes, cubes, 1e-9 * cubes) << h;
    if (h > 1e-4) {
      EXPECT_LT(sums_of(tool, pose, wall).cubes, cubes);
    }
  }
  // Beside the wall nothing must act, even where the wall is thickened.
  const Pose beside{Vec3(0.0551, 0, -0.003), kUpright};
  EXPECT_EQ(sums_of(tool, beside, wall, &up).cubes, 0.0);
  // An oblique thickening must extend obliquely from the wall's outline, and no farther.
  const Vec3 aslant = Vec3(0.5, 0.0, 1.0).normalized();
  EXPECT_EQ(sums_of(tool, {Vec3(-0.06, 0, -0.003), kUpright}, wall, &aslant).cubes, 0.0);
  EXPECT_GT(sums_of(tool, {Vec3(-0.06, 0, -0.02), kUpright}, wall, &aslant).cubes, 0.0);
}

}  // namespace
}  // namespace feltwire::depth_integrals_test

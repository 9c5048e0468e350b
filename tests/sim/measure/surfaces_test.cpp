#include "sim/measure/surfaces.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <numbers>

namespace feltwire::surfaces_test {
namespace {

TEST(Surfaces, PlaneAndSphereAreAsFarAsTheyAre) {
  EXPECT_EQ(plane_distance({3.0, -4.0, 0.25}).distance, 0.25);
  EXPECT_EQ(plane_distance({3.0, -4.0, -0.25}).distance, -0.25);
  const SurfaceDistance inside = sphere_distance({0.0, -0.03, 0.04}, 0.09);
  EXPECT_NEAR(inside.distance, -0.04, 1e-15);
  EXPECT_LT((inside.normal - Vec3(0.0, -0.6, 0.8)).norm(), 1e-15);
}

TEST(Surfaces, ACornerPushesWithEveryWallThatIsEntered) {
  const SurfaceDistance free = corner_distance({0.3, 0.1, 0.2});
  EXPECT_EQ(free.distance, 0.1);
  EXPECT_EQ(free.normal, Vec3::UnitY());
  const SurfaceDistance one = corner_distance({0.3, -0.1, 0.2});
  EXPECT_EQ(one.distance, -0.1);
  EXPECT_EQ(one.normal, Vec3::UnitY());
  const SurfaceDistance two = corner_distance({-0.3, 0.1, -0.4});
  EXPECT_NEAR(two.distance, -0.5, 1e-15);
  EXPECT_LT((two.normal - Vec3(0.6, 0.0, 0.8)).norm(), 1e-15);
  // The penalty force of three walls is the sum of each wall's force.
  const Command three = penalty(corner_distance({-0.001, -0.002, -0.003}), 1000.0);
  EXPECT_LT((three.elastic - Vec3(1.0, 2.0, 3.0)).norm(), 1e-12);
}

TEST(Surfaces, AnEdgeIsNearestToItselfOutsideAndToAFaceInside) {
  const SurfaceDistance edge = edge_distance({0.3, 0.4, 7.0});
  EXPECT_NEAR(edge.distance, 0.5, 1e-15);
  EXPECT_LT((edge.normal - Vec3(0.6, 0.8, 0.0)).norm(), 1e-15);
  EXPECT_EQ(edge_distance({0.3, -0.4, 7.0}).distance, 0.3);
  const SurfaceDistance inside = edge_distance({-0.3, -0.1, 7.0});
  EXPECT_EQ(inside.distance, -0.1);
  EXPECT_EQ(inside.normal, Vec3::UnitY());
}

TEST(Surfaces, APenaltyIsNothingOutside) {
  EXPECT_EQ(penalty({0.1, Vec3::UnitX()}, 1000.0).force(), Vec3::Zero());
  EXPECT_EQ(penalty({-0.002, Vec3::UnitX()}, 1000.0).elastic, Vec3(2.0, 0.0, 0.0));
}

const Vec3 kAround[] = {{0.088, 0.01, 0.004}, {-0.05, 0.06, 0.02},   {0.02, -0.03, 0.005},
                        {0.0, 0.062, -0.031}, {-0.04, -0.055, 0.03}, {0.095, 0.001, -0.002}};

TEST(BumpyTorus, WithoutBumpsTheDistanceIsExact) {
  const BumpyTorus smooth{.ring = 0.06, .tube = 0.03, .amplitude = 0.0};
  for (const Vec3& p : kAround) {
    const double exact = std::hypot(std::hypot(p.x(), p.y()) - 0.06, p.z()) - 0.03;
    const SurfaceDistance d = torus_distance(smooth, p);
    EXPECT_NEAR(d.distance, exact, 1e-15);
    EXPECT_NEAR(torus_distance(smooth, p - exact * d.normal).distance, 0.0, 1e-15);
  }
}

TEST(BumpyTorus, BumpsStandOutByTheirAmplitudeWhereTheyAreCounted) {
  const BumpyTorus torus;
  const double pi = std::numbers::pi;
  const auto outside = [&](double phi, double radius) {
    return bumpy_torus(torus, {radius * std::cos(phi), radius * std::sin(phi), 0.0}).value;
  };
  for (int bump = 0; bump < 24; ++bump) {
    const double phi = 2.0 * pi * bump / 24.0;
    EXPECT_NEAR(outside(phi, 0.091), 0.0, 1e-15);
    EXPECT_NEAR(outside(phi + pi / 24.0, 0.089), 0.0, 1e-15);
  }
  // Around the tube, the bumps are an eighth of a turn apart.
  const auto round_tube = [&](double theta, double r) {
    return bumpy_torus(torus, {0.06 + r * std::cos(theta), 0.0, r * std::sin(theta)}).value;
  };
  EXPECT_NEAR(round_tube(pi / 4.0, 0.031), 0.0, 1e-15);
  EXPECT_NEAR(round_tube(pi / 8.0, 0.029), 0.0, 1e-15);
}

TEST(BumpyTorus, TheGradientIsThatOfTheValue) {
  const BumpyTorus torus;
  constexpr double kStep = 1e-6;
  for (const Vec3& p : kAround) {
    const Vec3 gradient = bumpy_torus(torus, p).gradient;
    for (int i = 0; i < 3; ++i) {
      const Vec3 h = kStep * Vec3::Unit(i);
      const double difference =
          (bumpy_torus(torus, p + h).value - bumpy_torus(torus, p - h).value) / (2.0 * kStep);
      EXPECT_NEAR(gradient[i], difference, 1e-6) << p.transpose();
    }
  }
}

TEST(BumpyTorus, TheDistanceIsRightToFirstOrder) {
  const BumpyTorus torus;
  for (Vec3 p : kAround) {
    for (int i = 0; i < 50; ++i) {  // moves the point to the surface
      const SurfaceDistance d = torus_distance(torus, p);
      p -= d.distance * d.normal;
    }
    const Vec3 normal = torus_distance(torus, p).normal;
    for (const double depth : {1e-3, 1e-4, 1e-5}) {
      const double error = torus_distance(torus, p - depth * normal).distance + depth;
      // The error is at most half the largest curvature, about 150 / m, times the squared depth.
      EXPECT_LT(std::abs(error), 200.0 * depth * depth) << depth << " below " << p.transpose();
    }
  }
}

}  // namespace
}  // namespace feltwire::surfaces_test

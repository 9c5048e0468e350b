// Tests rotation vectors, lengths, directions and the velocity estimate.

#include "core/base/types.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <numbers>

#include "core/base/numeric.hpp"
#include "core/bounding/velocity.hpp"
#include "tests/core/support.hpp"

namespace feltwire::types_test {
namespace {

using test::Random;

constexpr double kPi = std::numbers::pi;
constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
constexpr double kInfinity = std::numeric_limits<double>::infinity();

Quaternion about(const Vec3& axis, double angle) {
  return Quaternion(Eigen::AngleAxisd(angle, axis));
}

TEST(RotationBetween, IsAxisTimesAngleInTheWorldFrame) {
  Random random(1);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 axis = random.direction();
    const double angle = random.uniform(0.0, kPi - 1e-6);
    const Quaternion from = about(random.direction(), random.uniform(-kPi, kPi));
    const Quaternion to = about(axis, angle) * from;
    const Vec3 rotation = rotation_between(from, to);
    EXPECT_LT((rotation - angle * axis).norm(), 1e-13);
    EXPECT_LT((rotation_between(to, from) + rotation).norm(), 1e-13);
    // The sign and the norm of a quaternion must not change the rotation.
    const Quaternion minus_to(-to.coeffs()), long_from(3.0 * from.coeffs()),
        short_to(1e-3 * to.coeffs());
    EXPECT_LT((rotation_between(from, minus_to) - rotation).norm(), 1e-13);
    EXPECT_LT((rotation_between(long_from, short_to) - rotation).norm(), 1e-13);
  }
}

TEST(RotationBetween, IsExactForSmallAngles) {
  Random random(2);
  for (int n = 0; n < 2000; ++n) {
    const Vec3 axis = random.direction();
    const double angle = std::abs(random.decades(-14.0, -2.0));
    const Vec3 rotation = rotation_between(Quaternion::Identity(), about(axis, angle));
    EXPECT_LT((rotation - angle * axis).norm(), 1e-15 * angle * 8);
  }
  const Quaternion q = about(Vec3(1, 2, 2) / 3.0, 1.234);
  EXPECT_EQ(rotation_between(q, q), Vec3::Zero());
  EXPECT_EQ(rotation_between(q, Quaternion(-q.coeffs())), Vec3::Zero());
}

TEST(RotationBetween, GoesTheShortWayRound) {
  const Vec3 axis = Vec3(2, -1, 2) / 3.0;
  for (const double beyond : {1e-12, 1e-6, 0.1, 1.0, 3.0}) {
    const Vec3 rotation = rotation_between(Quaternion::Identity(), about(axis, kPi + beyond));
    EXPECT_LT((rotation + (kPi - beyond) * axis).norm(), 1e-12) << beyond;
    const Vec3 before = rotation_between(Quaternion::Identity(), about(axis, kPi - beyond));
    EXPECT_LT((before - (kPi - beyond) * axis).norm(), 1e-12) << beyond;
  }
  EXPECT_NEAR(rotation_between(Quaternion::Identity(), Quaternion(0, 0, 1, 0)).norm(), kPi, 1e-15);
}

TEST(RotationBetween, WhatIsNoOrientationGivesZero) {
  const Quaternion good = about(Vec3::UnitX(), 0.5);
  for (int i = 0; i < 4; ++i)
    for (const double bad : {kNan, kInfinity, -kInfinity}) {
      Quaternion q = good;
      q.coeffs()[i] = bad;
      EXPECT_EQ(rotation_between(q, good), Vec3::Zero());
      EXPECT_EQ(rotation_between(good, q), Vec3::Zero());
      EXPECT_EQ(rotation_between(q, q), Vec3::Zero());
    }
  EXPECT_EQ(rotation_between(good, Quaternion(0, 0, 0, 0)), Vec3::Zero());
  EXPECT_EQ(rotation_between(Quaternion(0, 0, 0, 0), good), Vec3::Zero());
}

TEST(Numeric, LengthAndDirectionOverAllDoubles) {
  Random random(3);
  for (int n = 0; n < 20000; ++n) {
    const Vec3 u = random.direction();
    const double size = std::pow(10.0, random.uniform(-300.0, 307.0));
    EXPECT_NEAR(length(size * u) / size, 1.0, 1e-14);
    EXPECT_LT((direction(size * u) - u).norm(), 1e-14);
  }
  const double least = std::numeric_limits<double>::denorm_min(),
               most = std::numeric_limits<double>::max();
  EXPECT_EQ(length(Vec3(0, least, 0)), least);
  EXPECT_EQ(direction(Vec3(0, -least, 0)), Vec3(0, -1, 0));
  EXPECT_EQ(length(Vec3(most, 0, 0)), most);
  EXPECT_EQ(direction(Vec3(most, 0, 0)), Vec3(1, 0, 0));
  EXPECT_NEAR(direction(Vec3(most, most, most)).norm(), 1.0, 1e-15);
  EXPECT_EQ(length(Vec3::Zero()), 0.0);
  EXPECT_EQ(direction(Vec3::Zero()), Vec3::Zero());
  EXPECT_EQ(direction(Vec3(-0.0, 0, -0.0)), Vec3::Zero());
}

TEST(Numeric, WhatIsNotFiniteHasNoDirection) {
  for (const double bad : {kNan, kInfinity, -kInfinity})
    for (int i = 0; i < 3; ++i)
      for (const double other : {0.0, 1.0, 1e300}) {
        Vec3 v = Vec3::Constant(other);
        v[i] = bad;
        EXPECT_EQ(direction(v), Vec3::Zero());
        EXPECT_FALSE(std::isfinite(length(v)));
      }
}

TEST(Velocity, WithoutAFilterItIsTheDifference) {
  VelocityEstimate velocity;
  EXPECT_EQ(velocity.update(Vec3(1, -2, 4), 0.5), Vec3(2, -4, 8));
  EXPECT_EQ(velocity.update(Vec3(1, 1, 1), 0.0), Vec3(2, -4, 8));
  EXPECT_EQ(velocity.update(Vec3(1, 1, 1), -1.0), Vec3(2, -4, 8));
  EXPECT_EQ(velocity.update(Vec3(1, 1, 1), kNan), Vec3(2, -4, 8));
}

TEST(Velocity, StepResponseIsExponentialWhateverTheSteps) {
  const double cutoff = 50.0, time = 0.01;
  for (const int steps : {1, 7, 100}) {
    VelocityEstimate velocity(cutoff);
    const double step = time / steps;
    for (int n = 0; n < steps; ++n) velocity.update(Vec3(3.0 * step, 0, 0), step);
    EXPECT_NEAR(velocity.value().x(), 3.0 * (1.0 - std::exp(-2.0 * kPi * cutoff * time)), 1e-12);
  }
}

TEST(Velocity, WhatIsNotFiniteDoesNotStayInTheFilter) {
  for (const double cutoff : {0.0, 50.0}) {
    VelocityEstimate velocity(cutoff);
    velocity.update(Vec3(1e-3, 0, 0), 1e-3);
    const Vec3 before = velocity.value();
    velocity.update(Vec3(kNan, 0, 0), 1e-3);
    velocity.update(Vec3(0, kInfinity, 0), 1e-3);
    velocity.update(Vec3(0, 1e300, 0), 1e-300);
    EXPECT_EQ(velocity.value(), before);
  }
}

TEST(Turned, IsTheInverseOfTheRotationBetween) {
  const Quaternion from = Quaternion(0.3, -0.5, 0.7, 0.2).normalized();
  for (const Vec3& by : {Vec3(0.4, -1.2, 0.9), Vec3(1e-9, 0.0, -3e-9), Vec3(0.0, 3.0, 0.0)}) {
    const Quaternion to = turned(from, by);
    EXPECT_NEAR(to.norm(), 1.0, 1e-15);
    EXPECT_NEAR((rotation_between(from, to) - by).norm(), 0.0, 1e-15 + 1e-14 * by.norm());
  }
  EXPECT_EQ(turned(from, Vec3::Zero()).coeffs(), from.coeffs());
}

}  // namespace
}  // namespace feltwire::types_test

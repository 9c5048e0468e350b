// Tests damping as a scalar, along the axes and as a matrix.

#include "core/device/damping.hpp"

#include <gmock/gmock.h>

#include <limits>
#include <stdexcept>
#include <string>

#include "tests/core/support.hpp"

namespace feltwire::damping_test {
namespace {

using ::testing::HasSubstr;

constexpr double kPeriod = test::kModePeriod;

/// Returns a matrix with the eigenvalues 1 and 3 in the plane, and 5 along z.
Mat3 coupled() {
  Mat3 m;
  m << 2, 1, 0, 1, 2, 0, 0, 0, 5;
  return m;
}

TEST(Damping, LeastAndPerAxis) {
  EXPECT_EQ(Damping(2.0).least(), 2.0);
  EXPECT_EQ(Damping(2.0).per_axis(), Vec3(2, 2, 2));
  EXPECT_EQ(Damping(Vec3(3, 1, 2)).least(), 1.0);
  EXPECT_EQ(Damping(Vec3(3, 1, 2)).per_axis(), Vec3(3, 1, 2));
  EXPECT_NEAR(Damping(coupled()).least(), 1.0, 1e-12);
  EXPECT_NEAR((Damping(coupled()).per_axis() - Vec3(1, 1, 1)).norm(), 0.0, 1e-12);
}

TEST(Damping, QuadraticByHand) {
  const Vec3 dx(1, -2, 3);
  EXPECT_DOUBLE_EQ(Damping(2.0).quadratic(dx), 28.0);
  EXPECT_DOUBLE_EQ(Damping(Vec3(3, 1, 2)).quadratic(dx), 3.0 + 4.0 + 18.0);
  EXPECT_DOUBLE_EQ(Damping(coupled()).quadratic(dx), 2.0 - 4.0 + 8.0 + 45.0);
}

TEST(Damping, MoreOfItIsMoreInEveryDirection) {
  Damping d(coupled());
  d += 0.5;
  EXPECT_EQ(d.matrix(), Mat3(coupled() + 0.5 * Mat3::Identity()));
  EXPECT_NEAR(d.least(), 1.5, 1e-12);
  EXPECT_EQ(d.kind(), Damping::Kind::matrix);
}

TEST(Damping, WhatIsNoneIsRefusedByName) {
  const auto reason = [](const Damping& d) -> std::string {
    try {
      validate(d, "arm damping");
    } catch (const std::invalid_argument& e) {
      return e.what();
    }
    return "accepted";
  };
  const double nan = std::numeric_limits<double>::quiet_NaN();
  const double infinity = std::numeric_limits<double>::infinity();
  for (const Damping& good :
       {Damping(0.0), Damping(2.0), Damping(Vec3(1, 0, 2)), Damping(coupled())})
    EXPECT_EQ(reason(good), "accepted");
  for (const double bad : {nan, infinity, -1.0}) {
    EXPECT_THAT(reason(Damping(bad)), HasSubstr("arm damping must"));
    EXPECT_THAT(reason(Damping(Vec3(1, bad, 1))), HasSubstr("arm damping must"));
    Mat3 m = coupled();
    m(2, 2) = bad;
    EXPECT_THAT(reason(Damping(m)), HasSubstr("arm damping"));
  }
  Mat3 skewed = coupled();
  skewed(0, 1) += 1e-6;
  EXPECT_THAT(reason(Damping(skewed)), HasSubstr("give xy = yx"));
  skewed(0, 1) = coupled()(0, 1) + 1e-12;
  EXPECT_EQ(reason(Damping(skewed)), "accepted");
  Mat3 indefinite = coupled();
  indefinite(0, 1) = indefinite(1, 0) = 2.5;  // The smallest eigenvalue is 2 - 2.5.
  EXPECT_THAT(reason(Damping(indefinite)), HasSubstr("smallest eigenvalue is -0.5"));
}

TEST(Damping, WhereAnAxisHasNoneTheLawsThatNeedItSaySo) {
  BoundingConfig c = test::config("contact_frame");
  c.damping = Vec3(1, 0, 1);
  for (const std::string_view mode : {"contact_frame", "energy_tank"}) {
    c.mode = mode;
    try {
      Bounding bounding(c);
      FAIL() << mode;
    } catch (const std::invalid_argument& e) {
      EXPECT_THAT(e.what(), HasSubstr("damping must be above zero along every axis"));
      EXPECT_THAT(e.what(), HasSubstr("give an axis that hardly has any a small one"));
    }
  }
  c.mode = "per_axis";
  Bounding bounding(c);  // The axis without damping gets no force.
  const Command r = bounding
                        .step({Vec3(-1e-3, -1e-3, 0),
                               Vec3::Zero(),
                               kPeriod,
                               {Vec3(9, 9, 9), Vec3::Zero(), Vec3::Zero()}})
                        .rendered;
  EXPECT_NEAR((r.force() - Vec3(1, 0, 0)).norm(), 0.0, 1e-12);
}

TEST(Damping, PortEnergyBurnsByDirection) {
  PortEnergy axes(Vec3(3, 1, 2), Vec3(0.1, 0.2, 0.3), kPeriod);
  axes.step({}, Vec3(1e-3, 2e-3, 0), Vec3(0, 0, 0.1), kPeriod);
  EXPECT_NEAR(axes.burned(), (3e-6 + 4e-6 + 0.3e-2) / kPeriod, 1e-15);
  PortEnergy matrix(coupled(), 0.0, kPeriod);
  const Vec3 weak = Vec3(1, -1, 0).normalized() * 1e-3;
  matrix.step({}, weak, Vec3::Zero(), 2 * kPeriod);
  EXPECT_NEAR(matrix.burned(), 1.0 * 1e-6 / (2 * kPeriod), 1e-15);
  // A force of 3 N along the weak direction for 1 mm delivers 3 mJ, but the damping dissipates 0.5
  // + 1 mJ.
  matrix.step({3e3 * weak, Vec3::Zero(), Vec3::Zero()}, weak, Vec3::Zero(), kPeriod);
  EXPECT_NEAR(matrix.least_margin(), -1.5e-3, 1e-12);
  EXPECT_EQ(matrix.violations(), 1u);
}

TEST(Damping, AContactFrameGivesEachDirectionItsOwnColgateSlope) {
  for (const Damping& d : {Damping(Vec3(3, 1, 5)), Damping(coupled())})
    for (const Vec3& u : {Vec3(Vec3(1, -1, 0).normalized()), Vec3(0, 0, 1)}) {
      BoundingConfig c = test::config("contact_frame");
      c.damping = d;
      Bounding bounding(c);
      const Command r =
          bounding.step({-1e-3 * u, Vec3::Zero(), kPeriod, {1e6 * u, Vec3::Zero(), Vec3::Zero()}})
              .rendered;
      // Along n = L^-1 u the force is c (n.y) / |n|, with y = L' dx and n.y = u.dx / |n|.
      const double slope = 2.0 / kPeriod / u.dot(d.matrix().inverse() * u);
      EXPECT_NEAR((r.force() - slope * 1e-3 * u).norm(), 0.0, 1e-9);
    }
}

}  // namespace
}  // namespace feltwire::damping_test

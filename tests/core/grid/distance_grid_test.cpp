// Compares distance grids with closed forms.

#include "core/grid/distance_grid.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>

#include "core/base/splitmix.hpp"
#include "core/grid/signed_distance.hpp"
#include "core/mesh/mesh_distance.hpp"
#include "core/mesh/tessellation.hpp"
#include "tests/core/support.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::distance_grid_test {
namespace {

const double kNan = std::nan(""), kInfinity = std::numeric_limits<double>::infinity();

/// Returns a ring about z with radius `ring` and tube radius `tube` [m].
Solid torus(double ring, double tube) {
  const Vec3 half(ring + tube, ring + tube, tube);
  return {-half, half,
          [=](const Vec3& p) { return std::hypot(std::hypot(p.x(), p.y()) - ring, p.z()) - tube; }};
}

Vec3 torus_normal(const Vec3& p, double ring) {
  const Vec3 across(p.x(), p.y(), 0.0);
  return (p - ring * across.normalized()).normalized();
}

struct Errors {
  double distance = 0.0;  // [m]
  double angle = 0.0;     // [rad]
  double length = 0.0;    // error of the gradient's length relative to 1
};

/// Returns the largest errors in a ball's shell, from `in` inside the surface to `out` outside.
template <class Real>
Errors sphere_errors(const DistanceGrid<Real>& grid, double radius, double in, double out) {
  Errors worst;
  test::Random random(1);
  for (int i = 0; i < 4000; ++i) {
    const Vec3 n = random.direction();
    const double d = random.uniform(-in, out);
    const FieldPoint point = grid.at((radius + d) * n);
    worst.distance = std::max(worst.distance, std::abs(point.distance - d));
    worst.angle = std::max(worst.angle, test::angle(point.gradient, n));
    worst.length = std::max(worst.length, std::abs(point.gradient.norm() - 1.0));
  }
  return worst;
}

// The spline's error is h^3 times the third derivative. The linear form's error is h^2 times the
// second.
TEST(DistanceGrid, ABallIsItselfToTheThirdOrder) {
  constexpr double kRadius = 0.03;
  const Solid ball = solid_of(Shape(Sphere{kRadius}));
  Errors before;
  for (const double h : {2e-3, 1e-3, 0.5e-3}) {
    const DistanceGrid<double> grid(ball, {.resolution = h});
    const Errors errors = sphere_errors(grid, kRadius, 4 * h, 4 * h);
    EXPECT_LT(errors.distance, 0.2 * h * h * h / (kRadius * kRadius)) << h;
    EXPECT_LT(errors.angle, 0.5 * h * h / (kRadius * kRadius)) << h;
    EXPECT_LT(errors.length, 0.5 * h * h / (kRadius * kRadius)) << h;
    if (before.distance > 0.0) {
      EXPECT_GT(before.distance / errors.distance, 6.0);  // 8 in theory
      EXPECT_GT(before.angle / errors.angle, 3.0);        // 4 in theory
    }
    before = errors;
  }
}

TEST(DistanceGrid, LinearIsCoarserAndItsNormalsJump) {
  constexpr double kRadius = 0.03, h = 1e-3;
  const Solid ball = solid_of(Shape(Sphere{kRadius}));
  const auto largest_jump = [&](Interpolation interpolation) {
    const DistanceGrid<double> grid(ball, {.resolution = h, .interpolation = interpolation});
    double jump = 0.0;
    Vec3 last = grid.at({kRadius, 0.0, 0.0}).gradient;
    for (int i = 1; i <= 20000; ++i) {
      const double a = 1e-4 * i;
      const Vec3 now =
          grid.at(kRadius * Vec3(std::cos(a), std::sin(a) * 0.8, std::sin(a) * 0.6)).gradient;
      // minus the rotation of the ball's own normal
      jump = std::max(jump, test::angle(last, now) - 1e-4);
      last = now;
    }
    return jump;
  };
  EXPECT_LT(largest_jump(Interpolation::quadratic), 1e-4);
  EXPECT_GT(largest_jump(Interpolation::linear), 1e-2);
  const DistanceGrid<double> linear(ball,
                                    {.resolution = h, .interpolation = Interpolation::linear});
  EXPECT_LT(sphere_errors(linear, kRadius, 4 * h, 4 * h).distance,
            1.01 * h * h / (4.0 * (kRadius - 4 * h)));
}

TEST(DistanceGrid, FloatIsDoubleToItsLastDigits) {
  constexpr double kRadius = 0.03, h = 1e-3;
  const Solid ball = solid_of(Shape(Sphere{kRadius}));
  const DistanceGrid<double> exact(ball, {.resolution = h});
  const DistanceGrid<float> small(ball, {.resolution = h});
  EXPECT_LT(static_cast<double>(small.bytes()), 0.6 * static_cast<double>(exact.bytes()));
  test::Random random(2);
  double worst = 0.0;
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = (kRadius + random.uniform(-4 * h, 4 * h)) * random.direction();
    const FieldPoint a = exact.at(p), b = small.at(p);
    worst = std::max(worst, std::abs(a.distance - b.distance));
    EXPECT_LT((a.gradient - b.gradient).norm(), 1e-5);
  }
  EXPECT_LT(worst, 1e-8);
  EXPECT_GT(worst, 0.0);  // The difference shows that the grid uses float.
}

TEST(DistanceGrid, ATorus) {
  constexpr double kRing = 0.03, kTube = 0.01, h = 0.5e-3;
  const DistanceGrid<float> grid(torus(kRing, kTube), {.resolution = h});
  test::Random random(3);
  for (int i = 0; i < 2000; ++i) {
    const double phi = random.uniform(-4, 4), theta = random.uniform(-4, 4);
    const double d = random.uniform(-4 * h, 4 * h);
    const double rho = kRing + (kTube + d) * std::cos(theta);
    const Vec3 p(rho * std::cos(phi), rho * std::sin(phi), (kTube + d) * std::sin(theta));
    const FieldPoint point = grid.at(p);
    EXPECT_NEAR(point.distance, d, 1e-6);
    EXPECT_LT(test::angle(point.gradient, torus_normal(p, kRing)), 2e-3);
  }
}

// Flat faces must be exact. Edges and corners may be rounded only within two steps.
TEST(DistanceGrid, ABoxIsExactButWithinTwoStepsOfItsEdges) {
  constexpr double h = 1e-3;
  const Box box{Vec3(0.03, 0.02, 0.025)};
  const DistanceGrid<double> grid(solid_of(Shape(box)), {.resolution = h});
  test::Random random(4);
  double at_edges = 0.0;
  for (int i = 0; i < 20000; ++i) {
    Vec3 p;
    for (int axis = 0; axis < 3; ++axis)
      p[axis] = random.uniform(-1.0, 1.0) * (box.half_extents[axis] + 4 * h);
    const double exact = signed_distance(box, Side::outside, p).distance;
    if (std::abs(exact) > 4 * h) continue;
    // The distance has a kink at an edge, and inside the solid on the planes between two faces.
    Vec3 beyond = p.cwiseAbs() - box.half_extents;
    std::sort(beyond.begin(), beyond.end());
    const double to_kink = exact < 0.0 ? beyond[2] - beyond[1] : std::abs(beyond[1]);
    const double error = std::abs(grid.at(p).distance - exact);
    if (to_kink > 3.0 * h && (exact < 0.0 || beyond[1] < 0.0 || exact > 3.0 * h)) {
      EXPECT_LT(error, 0.03 * h) << p.transpose();
    }
    at_edges = std::max(at_edges, error);
  }
  EXPECT_LT(at_edges, 0.5 * h);
  EXPECT_GT(at_edges, 0.05 * h);  // The edges must have an error.
}

TEST(DistanceGrid, TheGradientIsThatOfTheDistance) {
  const DistanceGrid<double> grid(solid_of(Shape(Box{Vec3(0.01, 0.02, 0.015)})),
                                  {.resolution = 1e-3});
  test::Random random(5);
  constexpr double kStep = 1e-8;
  for (int i = 0; i < 3000; ++i) {
    Vec3 p;
    for (double& x : p) x = random.uniform(-0.02, 0.02);
    const FieldPoint point = grid.at(p);
    // Beyond the band the grid may limit the distance.
    if (std::abs(point.distance) > 7e-3) continue;
    for (int axis = 0; axis < 3; ++axis) {
      const Vec3 step = kStep * Vec3::Unit(axis);
      const double slope =
          (grid.at(p + step).distance - grid.at(p - step).distance) / (2.0 * kStep);
      EXPECT_NEAR(point.gradient[axis], slope, 1e-5);
    }
  }
}

TEST(DistanceGrid, BeyondTheBandItIsCoarseAndNeverOfTheWrongSign) {
  constexpr double kRadius = 0.05, h = 0.5e-3;
  const DistanceGrid<float> grid(solid_of(Shape(Sphere{kRadius})), {.resolution = h});
  test::Random random(6);
  for (int i = 0; i < 5000; ++i) {
    const double r = random.uniform(0.0, 0.1);
    const Vec3 p = r * random.direction();
    const FieldPoint point = grid.at(p);
    const double d = r - kRadius;
    EXPECT_EQ(point.distance > 0.0, d > 0.0) << r;
    if (std::abs(d) > grid.band()) {
      EXPECT_GE(std::abs(point.distance), grid.band() * 0.999) << r;
      EXPECT_LE(std::abs(point.distance), std::abs(d) + 4.0 * h) << r;
    }
    EXPECT_LE(grid.at_least(p, 1.0, kInfinity), d + 1e-9);
    EXPECT_LE(grid.at_least(p, -1.0, kInfinity), -d + 1e-9);
    EXPECT_LE(grid.at_least(p, 1.0, -kInfinity), d + 1e-9);
  }
  // Far away the lower bound must be large.
  EXPECT_GT(grid.at_least({1.0, 0.0, 0.0}, 1.0, 0.0), 0.9);
}

TEST(DistanceGrid, WhatIsNoPlaceHasNoDistance) {
  const DistanceGrid<float> grid(solid_of(Shape(Sphere{0.01})), {.resolution = 1e-3});
  for (const Vec3& p : {Vec3(kNan, 0, 0), Vec3(0, kNan, 0), Vec3(0, 0, kNan), Vec3(kInfinity, 0, 0),
                        Vec3(0, -kInfinity, kNan)}) {
    const FieldPoint point = grid.at(p);
    EXPECT_TRUE(std::isnan(point.distance));
    EXPECT_EQ(point.gradient, Vec3::Zero());
    EXPECT_EQ(grid.at_least(p, 1.0, 0.0), -kInfinity);
    FeatureMemory memory;
    for (const Side side : {Side::outside, Side::inside})
      EXPECT_EQ(
          surface_point(Grid{std::make_shared<DistanceGrid<float>>(grid)}, side, p, memory).depth,
          0.0);
  }
  EXPECT_GT(grid.at({1e300, -1e300, 1e300}).distance, 1e299);
}

/// Compares a group with single points for a ball of 30 mm.
template <class Real>
void compare_group(const DistanceGrid<Real>& grid, FieldGroup group, double rounding) {
  FieldGroup least = group;
  grid.at(group);
  for (const double sign : {1.0, -1.0}) {
    grid.at_least(least, sign, FieldGroup::Lanes::Constant(2e-3));
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane) {
      const auto l = static_cast<Eigen::Index>(lane);
      const FieldPoint alone = grid.at(group.place(lane));
      EXPECT_NEAR(group.distance[l], alone.distance, rounding);
      EXPECT_NEAR(group.gradient_x[l], alone.gradient.x(), rounding / grid.resolution());
      EXPECT_NEAR(group.gradient_y[l], alone.gradient.y(), rounding / grid.resolution());
      EXPECT_NEAR(group.gradient_z[l], alone.gradient.z(), rounding / grid.resolution());
      EXPECT_LE(least.distance[l], sign * (group.place(lane).norm() - 0.03));
    }
  }
}

TEST(DistanceGrid, EightAtOnceAreEachItself) {
  const Solid ball = solid_of(Shape(Sphere{0.03}));
  for (const Interpolation interpolation : {Interpolation::linear, Interpolation::quadratic}) {
    const GridOptions options{.resolution = 2e-3, .interpolation = interpolation};
    const DistanceGrid<float> narrow(ball, options);
    const DistanceGrid<double> wide(ball, options);
    test::Random random(5);
    for (int i = 0; i < 300; ++i) {
      // The points are close together at the surface, or spread inside and outside.
      const Vec3 middle = random.uniform(0.02, 0.04) * random.direction();
      const double spread = i % 2 == 0 ? 2e-3 : 0.06;
      FieldGroup group;
      for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
        group.put(lane, Vec3(middle + spread * random.uniform(0.0, 1.0) * random.direction()));
      compare_group(narrow, group, 3e-8);
      compare_group(wide, group, 1e-16);
    }
    FieldGroup bad;
    for (std::size_t lane = 0; lane < FieldGroup::kSize; ++lane)
      bad.put(lane, Vec3(0.03, 0.0, 0.0));
    bad.put(3, Vec3(0.0, kNan, 0.0));
    bad.put(5, Vec3(kInfinity, 0.0, 0.0));
    narrow.at(bad);
    EXPECT_NEAR(bad.distance[2], 0.0, 1e-4);
    EXPECT_TRUE(std::isnan(bad.distance[3]) && std::isnan(bad.distance[5]));
  }
}

TEST(DistanceGrid, TheSameBitsEveryTime) {
  const Solid solid = solid_of(TriangleMesh(icosphere(0.02, 3)));
  const DistanceGrid<float> a(solid, {.resolution = 1e-3}), b(solid, {.resolution = 1e-3});
  ASSERT_EQ(a.bricks(), b.bricks());
  test::Random random(7);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = random.uniform(0.0, 0.03) * random.direction();
    const FieldPoint x = a.at(p), y = b.at(p);
    EXPECT_EQ(x.distance, y.distance);
    EXPECT_EQ(x.gradient, y.gradient);
  }
}

TEST(DistanceGrid, RefusesWhatCannotBeSampled) {
  const Solid ball = solid_of(Shape(Sphere{0.05}));
  const auto error = [](const Solid& solid, const GridOptions& options) {
    try {
      const DistanceGrid<float> grid(solid, options);
    } catch (const std::invalid_argument& refused) {
      return std::string(refused.what());
    }
    return std::string("let through");
  };
  for (const double h : {0.0, -1e-3, kNan, kInfinity})
    EXPECT_EQ(error(ball, {.resolution = h}).rfind("resolution: must be above zero", 0), 0u) << h;
  for (const double h : {1e-9, 1e-30, 1e-300})
    EXPECT_NE(error(ball, {.resolution = h}).find("more than the limit of 1024 MiB"),
              std::string::npos)
        << h;
  // The resolution that the message suggests must work.
  const std::string small = error(ball, {.resolution = 0.2e-3, .max_bytes = 1 << 22});
  ASSERT_NE(small.find("give a larger one"), std::string::npos) << small;
  const double named = std::stod(small.substr(small.find("about ") + 6));
  EXPECT_EQ(error(ball, {.resolution = named, .max_bytes = 1 << 22}), "let through") << small;
  EXPECT_EQ(error(ball, {.resolution = 1e-3, .band = -1.0}).rfind("band: ", 0), 0u);
  Solid boundless = ball;
  boundless.high.x() = kInfinity;
  EXPECT_EQ(error(boundless, {}).rfind("the solid has no extent", 0), 0u);
  EXPECT_THROW(solid_of(Shape(Plane{})), std::invalid_argument);
}

TEST(DistanceGrid, AskingNeverAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  const DistanceGrid<float> grid(solid_of(Shape(Sphere{0.02})), {.resolution = 1e-3});
  double sum = 0.0;
  const std::size_t before = test::allocations();
  for (int i = 0; i < 10000; ++i) {
    const Vec3 p(1e-5 * i - 0.05, 0.01, 0.0);
    sum += grid.at(p).distance + grid.at_least(p, 1.0, 0.0);
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_NE(sum, 0.0);
}

// The force -k d grad d has a potential. A closed path must give no energy, inside the solid too.
TEST(DistanceGrid, AClosedPathGivesNoEnergy) {
  const Grid grid{std::make_shared<DistanceGrid<float>>(
      solid_of(Shape(Box{Vec3(0.02, 0.02, 0.02)})), GridOptions{.resolution = 1e-3})};
  constexpr int kSteps = 200000;
  FeatureMemory memory;
  double work = 0.0, moved = 0.0;
  const auto place = [](int i) {  // over an edge, in and out
    const double a = 2.0 * M_PI * i / kSteps;
    return Vec3(0.018 + 0.004 * std::cos(a), 0.018 + 0.004 * std::sin(a), 0.003 * std::sin(3 * a));
  };
  Vec3 last = place(0);
  for (int i = 1; i <= kSteps; ++i) {
    const Vec3 now = place(i);
    const SurfacePoint s = surface_point(grid, Side::outside, 0.5 * (last + now), memory);
    work += s.depth * s.normal.dot(now - last);
    moved += s.depth * (now - last).norm();
    last = now;
  }
  EXPECT_GT(moved, 1e-6);
  EXPECT_LT(std::abs(work), 1e-6 * moved);
}

}  // namespace
}  // namespace feltwire::distance_grid_test

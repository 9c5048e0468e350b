// Tests a ball as the tool: against closed forms, and equally for every kind of shape.

#include "core/contact/ball.hpp"

#include <gtest/gtest.h>

#include <cmath>

#include "core/grid/signed_distance.hpp"
#include "core/scene/scene.hpp"
#include "tests/core/support.hpp"

namespace feltwire::ball_test {
namespace {

constexpr double kRadius = 0.005;

SurfacePoint touch_once(const Shape& shape, Side side, const Vec3& p) {
  FeatureMemory memory;
  return ball_surface(shape, side, p, kRadius, memory);
}

TEST(Ball, IsAsDeepAsItsSurfaceIsInTheSolid) {
  const std::vector<Shape> shapes = {Plane{},
                                     Sphere{0.03},
                                     Box{Vec3(0.03, 0.02, 0.025)},
                                     Capsule{0.02, 0.02},
                                     Cylinder{0.02, 0.03},
                                     Cone{0.02, 0.02},
                                     Torus{0.03, 0.01}};
  test::Random random(1);
  for (const Shape& shape : shapes)
    for (int i = 0; i < 4000; ++i) {
      Vec3 p;
      for (double& x : p) x = random.uniform(-0.05, 0.05);
      const FieldPoint field = signed_distance(shape, Side::outside, p);
      const SurfacePoint s = touch_once(shape, Side::outside, p);
      EXPECT_NEAR(s.depth, std::max(0.0, kRadius - field.distance), 1e-15) << shape.index();
      if (!(s.depth > 1e-9) || field.distance < -0.01)
        continue;  // At larger depths two faces may be equally near.
      EXPECT_LT((s.normal - field.gradient).norm(), 1e-9) << shape.index() << ' ' << p.transpose();
      EXPECT_LT((s.point - s.depth * s.normal - p).norm(), 1e-12);
      if (field.distance > 0.0) {
        EXPECT_NEAR(signed_distance(shape, Side::outside, s.point).distance, kRadius, 1e-12);
      }
    }
}

TEST(Ball, InAHollowStandsInTheCorner) {
  const Box box{Vec3(0.03, 0.02, 0.025)};
  // The ball touches two walls. The force must be the sum of both.
  const SurfacePoint s = touch_once(box, Side::inside, {0.027, 0.018, 0.0});
  EXPECT_NEAR(s.depth, std::hypot(0.002, 0.003), 1e-15);
  EXPECT_NEAR(s.normal.x() / s.normal.y(), 2.0 / 3.0, 1e-9);
  EXPECT_EQ(touch_once(box, Side::inside, {0.0249, 0.0149, 0.0}).depth, 0.0);
  EXPECT_NEAR(touch_once(Sphere{0.03}, Side::inside, {0.0, 0.0, 0.026}).depth, 1e-3, 1e-15);
  EXPECT_NEAR(touch_once(Cylinder{0.03, 0.02}, Side::inside, {0.026, 0.0, 0.0}).depth, 1e-3, 1e-15);
  EXPECT_NEAR(touch_once(Plane{}, Side::inside, {1.0, 2.0, -0.004}).depth, 1e-3, 1e-15);
  EXPECT_NEAR(touch_once(Capsule{0.03, 0.02}, Side::inside, {0.0, 0.0, 0.046}).depth, 1e-3, 1e-15);
}

TEST(Ball, AGridIsFeltAsWhatItWasMadeFrom) {
  const Shape solid = Sphere{0.03};
  const Grid grid{
      std::make_shared<DistanceGrid<float>>(solid_of(solid), GridOptions{.resolution = 1e-3})};
  test::Random random(2);
  for (int i = 0; i < 2000; ++i) {
    const Vec3 p = (0.03 + random.uniform(-3e-3, 7e-3)) * random.direction();
    const SurfacePoint exact = touch_once(solid, Side::outside, p);
    const SurfacePoint sampled = touch_once(grid, Side::outside, p);
    EXPECT_NEAR(sampled.depth, exact.depth, 5e-6);
    if (exact.depth > 1e-5) {
      EXPECT_LT(test::angle(sampled.normal, exact.normal), 1e-3);
    }
  }
}

// A thin plate must still hold a ball that is pressed through the middle of the plate.
TEST(Ball, StaysOnTheSideItCameFrom) {
  const Box plate{Vec3(0.1, 0.1, 0.001)};
  FeatureMemory memory;
  for (double z = 0.007; z > -0.0009; z -= 1e-4) {
    const SurfacePoint s = ball_surface(plate, Side::outside, {0.01, 0.02, z}, kRadius, memory);
    EXPECT_NEAR(s.depth, std::max(0.0, 0.006 - z), 1e-12) << z;
    if (s.depth > 0.0) {
      EXPECT_EQ(s.normal, Vec3::UnitZ()) << z;
    }
  }
}

TEST(Ball, AScenesToolMustFit) {
  Object hollow;
  hollow.name = "hollow";
  hollow.shape = Sphere{0.004};
  hollow.felt_from = Side::inside;
  Scene scene("s", {hollow});
  const auto error = [&](double radius) {
    try {
      scene.set_tool({.radius = radius, .body = nullptr});
    } catch (const std::invalid_argument& refused) {
      return std::string(refused.what());
    }
    return std::string("let through");
  };
  EXPECT_EQ(error(0.003), "let through");
  EXPECT_NE(error(kRadius).find("too large for object 'hollow'"), std::string::npos);
  EXPECT_NE(error(-1.0).find("sphere.radius: must be above zero"), std::string::npos);
  EXPECT_NE(error(std::nan("")).find("sphere.radius"), std::string::npos);
  EXPECT_EQ(scene.tool().radius, 0.003);  // The refused tool must change nothing.
}

// The ball has the friction of a point: it sticks, and slips at the cone.
TEST(Ball, SticksAndSlips) {
  Object floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.material = {.stiffness = 1000, .static_friction = 0.5, .dynamic_friction = 0.4};
  ContactMemory memory;
  Command c = touch(floor, {Vec3(0, 0, 0.003), Vec3::Zero()}, memory, kRadius);
  EXPECT_NEAR(c.elastic.z(), 2.0, 1e-12);
  c = touch(floor, {Vec3(0.0005, 0, 0.003), Vec3::Zero()}, memory, kRadius);
  EXPECT_NEAR(c.frictional.x(), -0.5, 1e-12);
  c = touch(floor, {Vec3(0.005, 0, 0.003), Vec3::Zero()}, memory, kRadius);
  EXPECT_NEAR(c.frictional.x(), -0.8, 1e-12);
}

}  // namespace
}  // namespace feltwire::ball_test

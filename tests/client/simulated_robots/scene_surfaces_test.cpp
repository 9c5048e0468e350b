// Tests a scene file as the model of the robot's surroundings.

#include "client/simulated_robots/scene_surfaces.hpp"

#include <gtest/gtest.h>

#include <limits>
#include <vector>

#include "client/simulated_robots/point_robot.hpp"
#include "core/teleoperation/follower_servo.hpp"

namespace feltwire::scene_surfaces_test {
namespace {

constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);

/// Returns a floor at `height`, and a ball of 30 mm on the floor at z = 0.
std::shared_ptr<const Scene> floor_scene(double height, bool with_ball) {
  Object floor;
  floor.name = "floor";
  floor.shape = Plane{};
  floor.pose.position.z() = height;
  floor.material = {.stiffness = 2000.0, .damping = 2.0};
  std::vector<Object> objects{floor};
  if (with_ball) {
    Object ball;
    ball.name = "ball";
    ball.shape = Sphere{0.03};
    ball.pose.position = Vec3(0.1, 0.0, 0.03);
    ball.material = {.stiffness = 400.0, .static_friction = 0.6, .dynamic_friction = 0.5};
    objects.push_back(ball);
  }
  return std::make_shared<const Scene>("floor", objects);
}

TEST(SceneSurfaces, TellsTheNearestSurface) {
  SceneSurfaces surfaces(floor_scene(0.0, true));
  const SurfacePrior floor = surfaces.nearest(Vec3(0.0, 0.0, 0.02), 1e-3);
  EXPECT_NE(floor.key, 0u);
  EXPECT_NEAR((floor.point - Vec3::Zero()).norm(), 0.0, 1e-12);
  EXPECT_NEAR((floor.normal - Vec3::UnitZ()).norm(), 0.0, 1e-12);
  EXPECT_EQ(floor.stiffness, 2000.0);
  const SurfacePrior ball = surfaces.nearest(Vec3(0.1, 0.0, 0.07), 1e-3);
  EXPECT_NE(ball.key, 0u);
  EXPECT_NE(ball.key, floor.key);
  EXPECT_NEAR((ball.point - Vec3(0.1, 0.0, 0.06)).norm(), 0.0, 1e-9);
  EXPECT_EQ(ball.stiffness, 400.0);
  EXPECT_EQ(ball.friction, 0.5);
  // Inside the ball, the nearest surface must be the ball. Far away or at NaN there must be none.
  EXPECT_EQ(surfaces.nearest(Vec3(0.1, 0.0, 0.059), 1e-3).key, ball.key);
  EXPECT_EQ(surfaces.nearest(Vec3(0.0, 0.0, 0.5), 1e-3).key, 0u);
  EXPECT_EQ(surfaces.nearest(Vec3(0.0, 0.0, std::numeric_limits<double>::quiet_NaN()), 1e-3).key,
            0u);
  EXPECT_THROW(SceneSurfaces(nullptr), std::invalid_argument);
}

/// A robot moves down to a floor. In the robot's model the floor is 3 mm too low.
TEST(SceneSurfaces, ARobotTellsThemBeforeItTouchesAndCorrectsThem) {
  PointRobot robot(floor_scene(0.0, false), Vec3(0.0, 0.0, 0.03));
  FollowerOptions options;
  options.surfaces = std::make_shared<SceneSurfaces>(floor_scene(-3e-3, false));
  FollowerServo servo(robot.spec(), options);
  Nanoseconds now = std::chrono::seconds(7);
  RobotTarget target;
  target.state = LinkState::engaged;
  const auto go = [&](double height, int ticks) {
    for (int n = 0; n < ticks; ++n) {
      ++target.index;
      target.pose.position = Vec3(0.0, 0.0, height);
      servo.take(target, now);
      now += kPeriod;
      servo.tick(robot, now);
    }
    return servo.report(servo.wanted());
  };
  constexpr double kSeries = 1000.0 * 2000.0 / 3000.0;
  const RobotState before = go(0.02, 1000);
  EXPECT_EQ(before.contact.surface, 1u);
  EXPECT_FALSE(before.contact.touching);
  EXPECT_NEAR(before.contact.point.z(), -3e-3, 1e-9);
  EXPECT_NEAR(before.contact.stiffness, kSeries, 1e-9);
  target.known_surface = 1;
  const RobotState touches = go(-2e-3, 1000);
  EXPECT_TRUE(touches.contact.touching);
  EXPECT_EQ(touches.contact.surface, 1u) << "that the hand knows already";
  EXPECT_NEAR(touches.contact.point.z(), 0.0, 1e-4);
  const RobotState after = go(0.02, 1000);
  EXPECT_FALSE(after.contact.touching);
  EXPECT_EQ(after.contact.surface, 1u);
  EXPECT_NEAR(after.contact.point.z(), 0.0, 3e-4);
}

}  // namespace
}  // namespace feltwire::scene_surfaces_test

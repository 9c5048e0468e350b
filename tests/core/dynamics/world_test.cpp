#include "core/dynamics/world.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <array>
#include <cmath>
#include <numbers>

#include "core/local_model_extraction/extract.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/core/moving.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::world_test {
namespace {

using test::body;
using test::Hand;
using test::kWeightless;
using test::moving;
using test::object;

constexpr double kTick = kDefaultTick, kGravity = 9.81;
const Material kGrippy{.stiffness = 1000, .static_friction = 0.8, .dynamic_friction = 0.6};

Scene floating_ball(double mass = 0.2, const Material& material = kGrippy) {
  return moving({object("ball", Sphere{0.03}, material)}, {0}, {body("ball", mass)}, kWeightless);
}

TEST(World, OfASceneInWhichNothingMovesIsNone) {
  const Scene scene("still", {object("ball", Sphere{0.1})});
  EXPECT_EQ(scene.mechanism(), nullptr);
  EXPECT_THROW(World{scene}, std::invalid_argument);
}

TEST(World, BodiesFallByTheClosedFormOfTheIntegrator) {
  const Scene scene = moving({object("ball", Sphere{0.03})}, {0}, {body("ball", 0.2)});
  World world(scene);
  for (int n = 1; n <= 500; ++n) {
    ASSERT_TRUE(world.step());
    // v(n) = -g n T, z(n) = z(n-1) + v(n) T
    EXPECT_NEAR(world.objects()[0].pose.position.z(), -kGravity * kTick * kTick * n * (n + 1) / 2,
                1e-12);
    EXPECT_NEAR(world.velocity_at(0, world.objects()[0].pose.position).z(), -kGravity * kTick * n,
                1e-12);
  }
}

/// Newton's third law, up to rounding. The ball gets the opposite of the hand's force and of its
/// moment about the origin.
TEST(World, TakesTheMomentumThatTheHandsAreRefused) {
  constexpr double kMass = 0.2, kRadius = 0.03;
  const Scene scene = floating_ball(kMass);
  World world(scene);
  Hand left(world), right(world);
  Vec3 given = Vec3::Zero(), moment = Vec3::Zero();
  double pushed = 0.0;
  for (int n = 0; n < 2000; ++n) {
    // Two hands follow the ball, touch it sometimes and slide over it.
    const Vec3 centre = world.objects()[0].pose.position;
    const double t = 1e-3 * n;
    const std::array<Vec3, 2> places = {
        centre + Vec3(0.0295 + 1e-3 * std::sin(40 * t), 0.004 * std::sin(17 * t), 0.002),
        centre + Vec3(-0.0290 + 1e-3 * std::sin(31 * t), 0.003 * std::sin(11 * t + 1), 0.001)};
    int which = 0;
    for (Hand* hand : {&left, &right}) {
      const Vec3& place = places[static_cast<std::size_t>(which++)];
      const Vec3 force = hand->touch(place).force();
      world.push(hand->contacts, hand->memory, 1.0);
      given += kTick * force;
      moment += kTick * place.cross(force);
      pushed += kTick * force.norm();
    }
    ASSERT_TRUE(world.step());
  }
  ASSERT_GT(pushed, 0.5);  // [N s]
  EXPECT_NEAR((world.momentum() + given).norm(), 0.0, 1e-12 * pushed);
  const Vec3 angular = test::angular_momentum_of_ball(world, kMass, kRadius);
  EXPECT_NEAR((angular + moment).norm(), 0.0, 1e-13);
  // The ball must get angular momentum. Otherwise the check above proves nothing.
  EXPECT_GT(angular.norm(), 1e-6);
}

TEST(World, ASpringHasItsPeriod) {
  constexpr double kMass = 0.05, kStiffness = 300.0, kRest = 0.004;
  Body slider = body("slider", kMass);
  slider.joint = Joint::slide;
  slider.stiffness = kStiffness;
  slider.rest = kRest;
  const Scene scene =
      moving({object("knob", Box{Vec3::Constant(0.01)})}, {0}, {slider}, kWeightless);
  World world(scene);
  // x(n+1) = 2 x(n) - x(n-1) - (w T)^2 (x(n) - r), from rest at 0.
  const double theta = 2.0 * std::asin(0.5 * kTick * std::sqrt(kStiffness / kMass));
  for (int n = 1; n <= 2000; ++n) {
    ASSERT_TRUE(world.step());
    EXPECT_NEAR(world.objects()[0].pose.position.z(),
                kRest * (1.0 - std::cos((n + 0.5) * theta) / std::cos(0.5 * theta)), 1e-12);
  }
}

double complete_elliptic_integral(double modulus) {
  double a = 1.0, b = std::sqrt(1.0 - modulus * modulus);
  for (int i = 0; i < 20; ++i) {
    const double mean = 0.5 * (a + b);
    b = std::sqrt(a * b);
    a = mean;
  }
  return 0.5 * std::numbers::pi / a;
}

/// A rod starts level. The reference is a physical pendulum with an amplitude of 90 degrees.
TEST(World, AHingeSwingsWithItsPeriod) {
  constexpr double kLength = 0.2, kMass = 0.1, kRadius = 0.005;
  Body arm = body("arm", kMass);
  arm.joint = Joint::hinge;
  arm.axis = Vec3::UnitY();
  Object rod = object("rod", Cylinder{kRadius, kLength / 2}, {}, Vec3(kLength / 2, 0, 0));
  rod.pose.orientation = turn_to(Vec3::UnitZ(), Vec3::UnitX());
  const Scene scene = moving({rod}, {0}, {arm});
  World world(scene);
  std::vector<double> crossings;  // [s] zero crossings of the lowest point
  double last = 1.0;
  Vec3 before = world.objects()[0].pose.position;
  for (int n = 1; n <= 6000; ++n) {
    ASSERT_TRUE(world.step());
    const Vec3 centre = world.objects()[0].pose.position;
    // The speed is at most 1.8 m/s, with 15 m/s^2 along the arc.
    EXPECT_NEAR((world.velocity_at(0, centre) - (centre - before) / kTick).norm(), 0.0, 0.03);
    before = centre;
    const double x = centre.x();
    if (x * last < 0.0) crossings.push_back(kTick * (n - 1 + last / (last - x)));
    last = x;
  }
  ASSERT_GE(crossings.size(), 7u);
  const double inertia =
      // moment of inertia about the hinge
      kMass * (kLength * kLength / 3.0 + kRadius * kRadius / 4.0);
  const double small = std::sqrt(inertia / (kMass * kGravity * kLength / 2));
  const double period = 4.0 * small * complete_elliptic_integral(std::sin(std::numbers::pi / 4));
  const double measured = (crossings[6] - crossings[0]) / 3.0;
  EXPECT_NEAR(measured, period, 2e-4 * period);
}

TEST(World, ASliderStopsAtTheEndOfItsRange) {
  Body drawer = body("drawer", 0.3);
  drawer.joint = Joint::slide;
  drawer.low = -0.05;
  drawer.high = 0.0;
  const Scene scene = moving({object("front", Box{Vec3(0.05, 0.01, 0.02)})}, {0}, {drawer});
  World world(scene);
  double lowest = 0.0;
  for (int n = 0; n < 2000; ++n) {
    ASSERT_TRUE(world.step());
    lowest = std::min(lowest, world.objects()[0].pose.position.z());
  }
  const Vec3 place = world.objects()[0].pose.position;
  EXPECT_NEAR(place.z(), -0.05, 1e-4);
  EXPECT_GT(lowest, -0.055);  // The slider arrived at 1 m/s.
  EXPECT_NEAR(world.velocity_at(0, place).norm(), 0.0, 1e-9);
}

TEST(World, ABodyRestsOnWhatStands) {
  // MuJoCo gets a hollow box as six planes. A table is inside.
  Object room = object("room", Box{Vec3::Constant(0.2)}, kGrippy);
  room.felt_from = Side::inside;
  const Scene scene =
      moving({object("dice", Box{Vec3::Constant(0.02)}, kGrippy, {0, 0, 0.05}), room,
              object("table", Box{Vec3(0.05, 0.05, 0.01)}, kGrippy, {0, 0, -0.01}),
              object("ball", Sphere{0.02}, kGrippy, {0.15, 0, 0})},
             {0, -1, -1, 1}, {body("dice", 0.05, {0, 0, 0.05}), body("ball", 0.05)});
  EXPECT_EQ(scene.objects()[0].name, "room");  // Static objects come first.
  World world(scene);
  for (int n = 0; n < 1500; ++n) ASSERT_TRUE(world.step());
  EXPECT_NEAR(world.objects()[2].pose.position.z(), 0.02, 2e-4);   // on the table
  EXPECT_NEAR(world.objects()[3].pose.position.z(), -0.18, 2e-4);  // on the floor of the room
  EXPECT_NEAR(world.velocity_at(2, Vec3::Zero()).norm(), 0.0, 1e-6);
}

TEST(World, TheHandFeelsWhereTheBodyIsAndHowItMoves) {
  const Scene scene = floating_ball(0.2, {.stiffness = 1000, .damping = 2.0});
  World world(scene);
  Hand hand(world);
  for (int n = 0; n < 100; ++n) hand.step({-0.0299, 0, 0});  // The hand pushes along x.
  Hand still(world);
  const Vec3 centre = world.objects()[0].pose.position;
  const double speed = world.velocity_at(0, centre).x();
  ASSERT_GT(speed, 1e-3);
  const Vec3 in = centre + Vec3(0.029, 0, 0);  // 1 mm inside, on the front side
  const Command felt = still.touch(in);
  EXPECT_NEAR(felt.elastic.x(), 1.0, 1e-9);
  EXPECT_NEAR(felt.frictional.x(), 2.0 * speed, 1e-9);  // The body moves towards the hand.
  const LocalModel model = local_model(world, in, still.memory);
  ASSERT_EQ(model.count, 1);
  EXPECT_NEAR(model.patches[0].velocity.x(), speed, 1e-9);
  EXPECT_NEAR((model.patches[0].point - (centre + Vec3(0.03, 0, 0))).norm(), 0.0, 1e-9);
}

/// The stick point must move with its body.
TEST(World, FrictionRidesAlong) {
  const Scene scene = floating_ball(0.2, {.stiffness = 1000, .static_friction = 5.0});
  World world(scene);
  Hand pusher(world), rider(world);
  const Vec3 place(0, 0, 0.029);
  rider.touch(place);
  for (int n = 0; n < 60; ++n) pusher.step({-0.0295, 0, 0});
  const double moved = world.objects()[0].pose.position.x();
  ASSERT_GT(moved, 1e-5);
  EXPECT_GT(rider.touch(place).frictional.x(), 900.0 * moved);  // The body pulls the hand along.
}

TEST(World, IsTheSameTwice) {
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/workshop.json");
  const auto run = [&] {
    World world(scene);
    Hand hand(world);
    std::vector<double> all;
    for (int n = 0; n < 1500; ++n) {
      const double t = 1e-3 * n;
      const Vec3 felt =
          hand.step(scene.start().position +
                    Vec3(0.08 * std::sin(7 * t), 0.06 * std::sin(5 * t), 0.02 * std::sin(3 * t)))
              .force();
      all.insert(all.end(), {felt.x(), felt.y(), felt.z()});
    }
    for (const Object& o : world.objects())
      all.insert(all.end(), {o.pose.position.x(), o.pose.position.y(), o.pose.position.z(),
                             o.pose.orientation.w(), o.pose.orientation.x()});
    return all;
  };
  EXPECT_EQ(run(), run());
}

TEST(World, StepAndTouchNeverAllocate) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  const Scene scene = load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/workshop.json");
  World world(scene);
  Hand hand(world);
  const std::size_t before = test::allocations();
  double felt = 0.0;
  for (int n = 0; n < 2000; ++n) {
    const double t = 1e-3 * n;
    felt += hand.step(scene.start().position +
                      Vec3(0.08 * std::sin(7 * t), 0.06 * std::sin(5 * t), 0.01 * std::sin(3 * t)))
                .force()
                .norm();
  }
  EXPECT_EQ(test::allocations(), before);
  EXPECT_GT(felt, 0.0);
}

/// The reference computes contact with every moving object at every sample, each with its own
/// memory.
TEST(World, WhatIsOutOfReachIsLeftAloneAndChangesNoBit) {
  const Material soft{.stiffness = 400.0, .static_friction = 0.5, .dynamic_friction = 0.4};
  const std::array<Shape, 4> shapes = {Sphere{0.02}, Box{Vec3(0.03, 0.01, 0.015)},
                                       Capsule{0.01, 0.02}, Cylinder{0.015, 0.02}};
  std::vector<Object> objects;
  std::vector<Body> bodies;
  std::vector<int> body_of;
  for (int i = 0; i < 12; ++i) {
    const std::string name = "thing " + std::to_string(i);
    const Vec3 at(0.06 * (i % 4), 0.06 * (i / 4), 0.0);
    objects.push_back(object(name.c_str(), shapes[static_cast<std::size_t>(i) % 4], soft, at));
    bodies.push_back(body(name.c_str(), 20.0, at));
    body_of.push_back(i);
  }
  const Scene scene = moving(objects, body_of, bodies, kWeightless);
  World world(scene);
  Hand hand(world);
  std::vector<ContactMemory> memory(world.objects().size());
  std::size_t felt = 0, let_go = 0;
  for (int n = 0; n < 1500; ++n) {
    const double t = 4e-3 * n;
    const Tool tool{{0.09 + 0.12 * std::sin(2.1 * t), 0.06 + 0.08 * std::sin(1.3 * t),
                     0.005 * std::sin(7.0 * t)},
                    {0.1 * std::cos(t), 0.0, 0.0}};
    Command sum;
    for (std::size_t i = 0; i < memory.size(); ++i) {
      const bool before = memory[i].touching;
      const Vec3 against = tool.velocity - world.velocity_at(i, tool.position);
      const Command part = touch(world.objects()[i], {tool.position, against}, memory[i]);
      sum.elastic += part.elastic;
      sum.frictional += part.frictional;
      let_go += before && !memory[i].touching ? 1 : 0;
    }
    ASSERT_EQ(hand.touch(tool.position, tool.velocity), sum) << n;
    felt += sum.elastic.isZero(0.0) ? 0 : 1;
    world.push(hand.contacts, hand.memory, 1.0);
    // In a tick without a sample, the near objects keep their memory.
    if (n % 50 == 0) {
      world.step();
      world.push(hand.contacts, hand.memory, 1.0);
      for (std::size_t i = 0; i < memory.size(); ++i)
        touch(world.objects()[i], {tool.position, -world.velocity_at(i, tool.position)}, memory[i]);
    }
    world.step();
  }
  EXPECT_GT(felt, 100u);
  EXPECT_GT(let_go, 5u);
}

TEST(World, ALostBodyBeginsAnew) {
  const Scene scene =
      moving({object("ball", Sphere{0.03}, {}, {0.1, 0.2, 0.3})}, {0}, {body("ball", 0.2)});
  World world(scene);
  for (int n = 0; n < 6000 && world.counters().returned == 0; ++n) ASSERT_TRUE(world.step());
  EXPECT_EQ(world.counters().returned, 1u);
  EXPECT_NEAR((world.objects()[0].pose.position - Vec3(0.1, 0.2, 0.3)).norm(), 0.0, 1e-4);
  EXPECT_EQ(world.counters().resets, 0u);
}

}  // namespace
}  // namespace feltwire::world_test

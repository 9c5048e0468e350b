#include "core/contact/contact.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <random>

namespace feltwire::contact_test {
namespace {

Object object(Shape shape, Material material, Side side = Side::outside) {
  Object o;
  o.name = "object";
  o.shape = shape;
  o.felt_from = side;
  o.material = material;
  return o;
}

Tool at(const Vec3& position, const Vec3& velocity = Vec3::Zero()) { return {position, velocity}; }

const std::vector<std::pair<Shape, Side>> kSurfaces = {
    {Plane{}, Side::outside},
    {Plane{}, Side::inside},
    {Sphere{0.05}, Side::outside},
    {Sphere{0.05}, Side::inside},
    {Box{Vec3(0.05, 0.04, 0.02)}, Side::outside},
    {Box{Vec3(0.05, 0.04, 0.02)}, Side::inside},
    {Capsule{0.02, 0.04}, Side::outside},
    {Capsule{0.02, 0.04}, Side::inside},
    {Cylinder{0.04, 0.03}, Side::outside},
    {Cylinder{0.04, 0.03}, Side::inside},
};

Quaternion random_rotation(std::mt19937& random) {
  std::normal_distribution<double> normal;
  return Quaternion(normal(random), normal(random), normal(random), normal(random)).normalized();
}

/// A hand that moves at random within a ball of some centimetres. Its steps are fractions of a
/// millimetre.
class Wanderer {
 public:
  explicit Wanderer(unsigned seed) : random_(seed) {}
  Vec3 step() {
    std::normal_distribution<double> normal(0.0, 2e-4);
    velocity_ = 0.95 * velocity_ + Vec3(normal(random_), normal(random_), normal(random_));
    position_ += velocity_;
    position_ *= 0.999;
    return position_;
  }

 private:
  std::mt19937 random_;
  Vec3 position_ = Vec3(0.01, 0.0, 0.02), velocity_ = Vec3::Zero();
};

TEST(Contact, PressedWallAnswersStiffnessTimesDepth) {
  const Object wall = object(Plane{}, {.stiffness = 40000});
  ContactMemory memory;
  for (const double depth : {1e-9, 1e-4, 0.5e-3, 0.01}) {
    const Command c = touch(wall, at(Vec3(0.1, -0.2, -depth)), memory);
    EXPECT_DOUBLE_EQ(c.elastic.z(), 40000 * depth);
    EXPECT_EQ(c.elastic.head<2>(), Vec3::Zero().head<2>());
    EXPECT_EQ(c.frictional, Vec3::Zero());
    EXPECT_EQ(c.torque, Vec3::Zero());
  }
  EXPECT_EQ(touch(wall, at(Vec3(0.1, -0.2, 1e-12)), memory).force(), Vec3::Zero());
  EXPECT_FALSE(memory.touching);
}

TEST(Contact, DampingResistsAndNeverPulls) {
  const Object wall = object(Plane{}, {.stiffness = 1000, .damping = 5});
  ContactMemory memory;
  const Vec3 pressed(0, 0, -0.001);  // 1 N
  EXPECT_DOUBLE_EQ(touch(wall, at(pressed, Vec3(0, 0, -0.1)), memory).frictional.z(), 0.5);
  EXPECT_DOUBLE_EQ(touch(wall, at(pressed, Vec3(0, 0, 0.1)), memory).frictional.z(), -0.5);
  const Command fast = touch(wall, at(pressed, Vec3(0, 0, 10.0)), memory);
  EXPECT_DOUBLE_EQ(fast.elastic.z(), 1.0);
  EXPECT_EQ(fast.force().z(), 0.0);
  EXPECT_EQ(touch(wall, at(pressed, Vec3(0.3, 0.4, 0)), memory).frictional, Vec3::Zero());
}

TEST(Contact, ViscousFrictionOpposesTheTangentialVelocityOnly) {
  const Object wall = object(Plane{}, {.stiffness = 40000, .viscous_friction = 10});
  ContactMemory memory;
  const Command c = touch(wall, at(Vec3(0, 0, -1e-4), Vec3(0.1, -0.2, -0.3)), memory);
  EXPECT_NEAR((c.frictional - Vec3(-1, 2, 0)).norm(), 0.0, 1e-15);
  EXPECT_DOUBLE_EQ(c.elastic.z(), 4.0);
}

TEST(Contact, SphereIsFeltAlongTheRadius) {
  const Object ball = object(Sphere{0.09}, {.stiffness = 5000});
  const Vec3 u = Vec3(1, -2, 2) / 3.0;
  ContactMemory memory;
  EXPECT_NEAR((touch(ball, at(0.088 * u), memory).elastic - 10.0 * u).norm(), 0.0, 1e-12);
}

TEST(Contact, SpringCycleGivesBackExactlyWhatItTook) {
  // In the stuck state the force is linear in the position. The trapezoidal rule is then exact.
  const Object wall = object(Plane{}, {.stiffness = 1000, .static_friction = 2.0});
  ContactMemory memory;
  const int steps = 1000;
  double energy = 0.0, exchanged = 0.0;
  Vec3 before = Vec3::Zero(), force = Vec3::Zero();
  for (int i = 0; i <= steps; ++i) {
    const double angle = 2.0 * M_PI * i / steps;
    const Vec3 p(0.001 * std::sin(angle), 0.0005 * std::sin(2 * angle),
                 -0.003 - 0.001 * std::cos(angle));
    const Vec3 now = touch(wall, at(p), memory).force();
    EXPECT_FALSE(memory.slipping);
    if (i > 0) {
      const double work = 0.5 * (force + now).dot(p - before);
      energy += work;
      exchanged += std::abs(work);
    }
    before = p;
    force = now;
  }
  EXPECT_GT(exchanged, 1e-6);
  EXPECT_NEAR(energy, 0.0, 1e-12 * exchanged);
}

TEST(Contact, SticksToStaticAndSlipsAtDynamicFriction) {
  const Material m{.stiffness = 1000, .static_friction = 0.6, .dynamic_friction = 0.4};
  const Object wall = object(Plane{}, m);
  const double depth = 0.001, pressed = 1.0;  // [m], [N]
  ContactMemory memory;
  const auto friction = [&](double x) { return touch(wall, at(Vec3(x, 0, -depth)), memory); };
  EXPECT_EQ(friction(0.0).frictional, Vec3::Zero());

  // Movement out: a spring up to mu_s F_n = 0.6 N at 0.6 mm, then mu_d F_n.
  for (double x = 1e-5; x < 0.599e-3; x += 1e-5) {
    EXPECT_NEAR(friction(x).frictional.x(), -1000 * x, 1e-12);
    EXPECT_FALSE(memory.slipping);
  }
  double last = 0.0;
  for (double x = 0.601e-3; x < 3e-3; x += 1e-5) {
    last = x;
    const Command c = friction(x);
    EXPECT_TRUE(memory.slipping);
    EXPECT_NEAR(c.frictional.x(), -0.4 * pressed, 1e-12);
    EXPECT_EQ(c.frictional.z(), 0.0);
  }
  // Movement back: the contact sticks at once. The spring unloads from -0.4 N through zero to +0.6
  // N, and the contact slips again.
  const double anchor = memory.anchor.x();
  EXPECT_NEAR(anchor, last - 0.4e-3, 1e-15);  // The end of the spring moves the anchor.
  for (double x = anchor + 0.399e-3; x > anchor - 0.599e-3; x -= 1e-5) {
    EXPECT_NEAR(friction(x).frictional.x(), -1000 * (x - anchor), 1e-12);
    EXPECT_FALSE(memory.slipping);
  }
  EXPECT_NEAR(friction(anchor - 0.601e-3).frictional.x(), 0.4, 1e-12);
  EXPECT_TRUE(memory.slipping);
}

TEST(Contact, LettingGoOfTheSurfaceShrinksTheCone) {
  const Object wall =
      object(Plane{}, {.stiffness = 1000, .static_friction = 0.6, .dynamic_friction = 0.4});
  ContactMemory memory;
  touch(wall, at(Vec3(0, 0, -0.001)), memory);
  EXPECT_NEAR(touch(wall, at(Vec3(0.0005, 0, -0.001)), memory).frictional.x(), -0.5, 1e-12);
  EXPECT_NEAR(touch(wall, at(Vec3(0.0005, 0, -0.0005)), memory).frictional.x(), -0.2, 1e-12);
  // The tool lifts off. The next contact has a new anchor.
  touch(wall, at(Vec3(0.0005, 0, 0.001)), memory);
  EXPECT_EQ(touch(wall, at(Vec3(0.0005, 0, -0.001)), memory).frictional, Vec3::Zero());
}

TEST(Contact, FrictionNeverLeavesItsConeNorTheTangentPlane) {
  for (unsigned surface = 0; surface < kSurfaces.size(); ++surface) {
    const Material m{.stiffness = 800, .static_friction = 0.7, .dynamic_friction = 0.3};
    const Object o = object(kSurfaces[surface].first, m, kSurfaces[surface].second);
    Wanderer hand(surface);
    ContactMemory memory;
    int stuck = 0, slipped = 0;
    for (int i = 0; i < 50000; ++i) {
      const Command c = touch(o, at(hand.step()), memory);
      const double normal = c.elastic.norm(), tangential = c.frictional.norm();
      EXPECT_LE(tangential, m.static_friction * normal * (1 + 1e-12));
      EXPECT_NEAR(c.frictional.dot(c.elastic), 0.0, 1e-12 * (1 + normal) * tangential);
      if (memory.slipping) {
        EXPECT_NEAR(tangential, m.dynamic_friction * normal, 1e-12 * (1 + normal));
        ++slipped;
      } else if (tangential > 0.0) {
        ++stuck;
      }
    }
    EXPECT_GT(stuck, 30) << surface;
    EXPECT_GT(slipped, 30) << surface;
  }
}

TEST(Contact, SlidingRoundABallIsHeldBackAllTheWay) {
  const double radius = 0.05, depth = 0.002;
  const Object ball =
      object(Sphere{radius}, {.stiffness = 1000, .static_friction = 0.5, .dynamic_friction = 0.5});
  ContactMemory memory;
  for (int i = 0; i < 4000; ++i) {
    const double angle = i * 2.0 * M_PI / 2000;
    const Vec3 out(std::cos(angle), std::sin(angle), 0), forward(-out.y(), out.x(), 0);
    const Command c = touch(ball, at((radius - depth) * out), memory);
    if (i < 100) continue;  // The spring stretches first.
    EXPECT_TRUE(memory.slipping);
    EXPECT_NEAR((c.frictional + 1.0 * forward).norm(), 0.0, 1e-6);
    EXPECT_NEAR((c.elastic - 2.0 * out).norm(), 0.0, 1e-12);
  }
}

TEST(Contact, SmoothMaterialKeepsNoAnchor) {
  const Object wall = object(Plane{}, {.stiffness = 1000, .viscous_friction = 1.0});
  ContactMemory memory;
  touch(wall, at(Vec3(0.3, 0.2, -0.001), Vec3(1, 0, 0)), memory);
  touch(wall, at(Vec3(0.4, 0.2, -0.001), Vec3(1, 0, 0)), memory);
  EXPECT_EQ(memory.anchor, Vec3::Zero());
  EXPECT_TRUE(memory.touching);
}

TEST(Contact, MovingAndTurningEverythingTurnsTheForce) {
  std::mt19937 random(7);
  for (unsigned surface = 0; surface < kSurfaces.size(); ++surface) {
    const Material m{.stiffness = 800,
                     .damping = 2,
                     .static_friction = 0.7,
                     .dynamic_friction = 0.3,
                     .viscous_friction = 1};
    const Object here = object(kSurfaces[surface].first, m, kSurfaces[surface].second);
    Object there = here;
    there.pose = {Vec3(0.3, -0.2, 0.5), random_rotation(random)};
    Wanderer hand(surface);
    ContactMemory memory_here, memory_there;
    Vec3 before = hand.step();
    int touched = 0;
    for (int i = 0; i < 5000; ++i) {
      const Vec3 p = hand.step(), v = (p - before) / 1e-3;
      before = p;
      const Command a = touch(here, at(p, v), memory_here);
      const Command b = touch(
          there, at(there.pose.orientation * p + there.pose.position, there.pose.orientation * v),
          memory_there);
      // Rounding may put a sample at the border on either side of the border. Rounding must change
      // nothing else.
      if (memory_here.touching != memory_there.touching) continue;
      if (memory_here.slipping != memory_there.slipping) break;
      EXPECT_NEAR((there.pose.orientation * a.elastic - b.elastic).norm(), 0.0, 1e-9);
      EXPECT_NEAR((there.pose.orientation * a.frictional - b.frictional).norm(), 0.0, 1e-9);
      touched += memory_here.touching;
    }
    EXPECT_GT(touched, 30) << surface;
  }
}

TEST(Contact, FarFromTheOriginOnlyThePositionsOwnDigitsAreLost) {
  Object ball = object(Sphere{0.05}, {.stiffness = 1000, .static_friction = 1.0});
  ball.pose.position = Vec3(1e6, -1e6, 1e6);
  ContactMemory memory;
  const Command c = touch(ball, at(ball.pose.position + Vec3(0, 0, 0.049)), memory);
  // At 1e6 m, a double resolves 1e-10 m.
  EXPECT_NEAR((c.elastic - Vec3(0, 0, 1.0)).norm(), 0.0, 1e-6);
}

TEST(Contact, TinyAndHugeShapesAnswerInProportion) {
  for (const double size : {1e-9, 1e-3, 1e6}) {
    const Object ball = object(Sphere{size}, {.stiffness = 1000, .static_friction = 1.0});
    ContactMemory memory;
    const Command c = touch(ball, at(Vec3(0, 0.75 * size, 0)), memory);
    EXPECT_NEAR(c.elastic.y() / (250 * size), 1.0, 1e-15);
    touch(ball, at(size * Vec3(0.01, 0.75, 0)), memory);
    EXPECT_FALSE(memory.slipping);
    EXPECT_NEAR(memory.anchor.y() / size, 1.0, 1e-15);
  }
}

TEST(Contact, WhatCannotBeComputedIsNoForce) {
  const Object wall = object(Plane{}, {.stiffness = 1e9, .damping = 1e6, .static_friction = 100});
  ContactMemory memory;
  EXPECT_EQ(touch(wall, at(Vec3(0, 0, -1e305)), memory).force(), Vec3::Zero());
  EXPECT_FALSE(memory.touching);
  touch(wall, at(Vec3(0, 0, -0.1)), memory);
  EXPECT_EQ(touch(wall, at(Vec3(0, 0, -0.1), Vec3(0, 0, -1e305)), memory).force(), Vec3::Zero());
}

}  // namespace
}  // namespace feltwire::contact_test

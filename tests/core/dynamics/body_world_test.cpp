// Tests a tool with a body against moving objects.

#include <gtest/gtest.h>

#include <cmath>

#include "core/mesh/tessellation.hpp"
#include "tests/core/moving.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::body_world_test {
namespace {

constexpr double kTick = 1e-3, kMass = 0.2, kRadius = 0.03;
const Material kRubber{
    .stiffness = 1000.0, .damping = 1.0, .static_friction = 0.6, .dynamic_friction = 0.4};

Scene with_body(Scene scene, std::size_t points = 600) {
  const Box box{Vec3(0.03, 0.02, 0.01)};
  scene.set_tool({.radius = 0.0,
                  .body = std::make_shared<const BodyTool>(point_shell(tessellate(box, 3), points),
                                                           ToolCoupling{}, 2.4e-3)});
  return scene;
}

Scene floating_ball() {
  return with_body(test::moving({test::object("ball", Sphere{kRadius}, kRubber)}, {0},
                                {test::body("ball", kMass)}, test::kWeightless));
}

/// A hand with a body as its tool. Each step computes the contact, pushes the objects and runs a
/// tick.
struct Holder {
  explicit Holder(World& in) : world(in), contacts(in.contact_state()) {}
  Command touch(const Pose& hand) {
    return world.touch(hand, Vec3::Zero(), kTick, memory, contacts);
  }
  void push() { world.push(contacts, memory, 1.0); }
  World& world;
  BodyMemory memory;
  BodyContactState contacts;
};

// Newton's third law, up to rounding. The ball gets the opposite of the hands' forces and of their
// moments about the origin.
TEST(BodyWorld, TakesTheMomentumThatTheHandsAreRefused) {
  const Scene scene = floating_ball();
  World world(scene);
  Holder left(world), right(world);
  Vec3 given = Vec3::Zero(), moment = Vec3::Zero();
  double pushed = 0.0, rubbed = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const Vec3 centre = world.objects()[0].pose.position;
    const double t = kTick * n;
    const std::array<Pose, 2> hands = {
        Pose{centre + Vec3(0.0585 + 1e-3 * std::sin(40 * t), 0.004 * std::sin(17 * t), 0.002),
             Quaternion(Eigen::AngleAxisd(0.2 * std::sin(13 * t), Vec3::UnitZ()))},
        Pose{centre + Vec3(-0.0580 + 1e-3 * std::sin(31 * t), 0.003 * std::sin(11 * t + 1), 0.001),
             Quaternion(Eigen::AngleAxisd(0.2 * std::sin(9 * t), Vec3::UnitX()))}};
    int which = 0;
    for (Holder* hand : {&left, &right}) {
      const Command felt = hand->touch(hands[static_cast<std::size_t>(which++)]);
      hand->push();
      if (hand->memory.contact.touching == 0) continue;
      given += kTick * felt.force();
      moment += kTick * (hand->memory.pose.position.cross(felt.force()) + felt.torque);
      pushed += kTick * felt.force().norm();
      rubbed += kTick * felt.frictional.norm();
    }
    ASSERT_TRUE(world.step());
  }
  ASSERT_GT(pushed, 0.3);  // [N s]
  ASSERT_GT(rubbed, 0.01);
  EXPECT_NEAR((world.momentum() + given).norm(), 0.0, 1e-12 * pushed);
  const Vec3 angular = test::angular_momentum_of_ball(world, kMass, kRadius);
  EXPECT_NEAR((angular + moment).norm(), 0.0, 1e-12);
  EXPECT_GT(angular.norm(), 1e-6);
}

TEST(BodyWorld, ItPushesABallAlongAndItsSpeedIsTheHands) {
  const Scene scene = floating_ball();
  World world(scene);
  Holder hand(world);
  for (int n = 0; n < 2000; ++n) {
    hand.touch({Vec3(0.065 - 1e-4 * n, 0, 0), Quaternion::Identity()});
    hand.push();
    ASSERT_TRUE(world.step());
  }
  EXPECT_LT(world.velocity_at(0, world.objects()[0].pose.position).x(), -0.09);
  EXPECT_LT(world.objects()[0].pose.position.x(), hand.memory.pose.position.x() - 0.05);
}

// Friction alone, without a normal push, must drag a block. The block oscillates on the coupling
// about the hand's speed. The initial jerk limits the amplitude.
TEST(BodyWorld, FrictionDrawsABlockAlongASlide) {
  Body block = test::body("block", kMass);
  block.joint = Joint::slide;
  block.axis = Vec3::UnitX();
  const Scene scene =
      with_body(test::moving({test::object("block", Box{Vec3(0.1, 0.1, 0.01)}, kRubber)}, {0},
                             {block}, test::kWeightless));
  World world(scene);
  Holder hand(world);
  constexpr double kSpeed = 0.02;
  double largest = 0.0;
  for (int n = 0; n < 1500; ++n) {
    const double in = 2e-3 * std::min(1.0, n / 100.0);
    const double along = n < 200 ? 0.0 : kSpeed * kTick * (n - 200);
    const Pose at{Vec3(along, 0, 0.02 - in), Quaternion::Identity()};
    largest = std::max(largest, std::abs(hand.touch(at).force().x()));
    hand.push();
    ASSERT_TRUE(world.step());
  }
  const double swing = kSpeed * std::sqrt(kMass / ToolCoupling{}.stiffness);  // [m] amplitude
  EXPECT_NEAR(world.objects()[0].pose.position.x(), kSpeed * 1.3, 1.2 * swing);
  EXPECT_NEAR(largest, ToolCoupling{}.stiffness * swing, 0.2 * ToolCoupling{}.stiffness * swing);
}

TEST(BodyWorld, AHandThatIsSilentStandsAndNothingAllocates) {
  const Scene scene = floating_ball();
  World world(scene);
  Holder hand(world);
  const std::size_t before = test::allocations();
  hand.touch({Vec3(0.059, 0, 0), Quaternion::Identity()});
  for (int n = 0; n < 500; ++n) {
    hand.push();  // Without a sample the hand stays, and the ball has its present position.
    ASSERT_TRUE(world.step());
  }
#ifndef FELTWIRE_SANITIZED
  EXPECT_EQ(test::allocations(), before);
#else
  static_cast<void>(before);
#endif
  // The compressed spring pushes the ball away. The hand must then have no contact.
  EXPECT_LT(world.objects()[0].pose.position.x(), -1e-3);
  EXPECT_EQ(hand.contacts.forces[0], Vec3::Zero());
}

}  // namespace
}  // namespace feltwire::body_world_test

// Tests a tool with mass among moving bodies, and in a static scene.

#include <gtest/gtest.h>

#include <cmath>

#include "core/local_model_extraction/body_points.hpp"
#include "tests/core/massive_tool.hpp"
#include "tests/core/moving.hpp"

namespace feltwire::massive_world_test {
namespace {

constexpr double kTick = 1e-3, kBall = 0.2, kRadius = 0.03, kMass = 0.3;
const Material kRubber{
    .stiffness = 1000.0, .damping = 1.0, .static_friction = 0.6, .dynamic_friction = 0.4};
const Pose kAbove{Vec3(0.0, 0.0, 0.3), Quaternion::Identity()};

Scene with_tool(Scene scene, ToolInertia inertia, const ToolCoupling& coupling = {}) {
  scene.set_tool({.radius = 0.0,
                  .body = std::make_shared<const BodyTool>(
                      test::massive(kMass, coupling, std::move(inertia), 400))});
  return scene;
}

Scene floating_ball(const ToolInertia& inertia, const ToolCoupling& coupling = {}) {
  return with_tool(test::moving({test::object("ball", Sphere{kRadius}, kRubber)}, {0},
                                {test::body("ball", kBall)}, test::kWeightless),
                   inertia, coupling);
}

struct Holder {
  explicit Holder(World& in) : world(in), contacts(in.contact_state()) {}
  Command touch(const Pose& hand, double elapsed = kTick) {
    return world.touch(hand, Vec3::Zero(), elapsed, memory, contacts);
  }
  void push() { world.push(contacts, memory, 1.0); }
  World& world;
  BodyMemory memory;
  BodyContactState contacts;
};

// The tool hits a ball. The total momentum must stay constant through impact and friction.
TEST(MassiveWorld, AnImpactKeepsTheMomentum) {
  const Scene scene = floating_ball({}, {.stiffness = 200.0});
  World world(scene);
  Holder hand(world);
  Vec3 given = Vec3::Zero();
  const Pose device{Vec3(0.066, 0.004, 0.0), Quaternion::Identity()};
  hand.touch(device);
  hand.memory.velocity.linear.x() = -0.5;
  double met = 0.0;
  for (int n = 0; n < 400; ++n) {
    const Command felt = hand.touch(device);
    hand.push();
    given += kTick * felt.force();
    met += static_cast<double>(hand.memory.contact.touching);
    ASSERT_TRUE(world.step());
    const Vec3 all = world.momentum() + kMass * hand.memory.velocity.linear + given;
    // The tolerance covers forces that the world scales down to stay passive.
    ASSERT_NEAR((all - Vec3(-0.5 * kMass, 0.0, 0.0)).norm(), 0.0, 2e-3 * 0.5 * kMass) << n;
  }
  EXPECT_GT(met, 10.0);
  EXPECT_LT(world.momentum().x(), -0.02) << "the ball was pushed";
}

// Gravity acts on the tool. The hand must feel a change of gravity.
TEST(MassiveWorld, WeighsByTheGravityOfTheWorld) {
  const Scene scene = floating_ball({.gravity = Vec3(0.0, 0.0, -100.0), .damping = 20.0});
  World world(scene);
  Holder hand(world);
  Command felt;
  const auto run = [&](int steps) {
    for (int n = 0; n < steps; ++n) {
      felt = hand.touch(kAbove);
      hand.push();
      ASSERT_TRUE(world.step());
    }
  };
  run(2000);
  EXPECT_LT(felt.force().norm(), 1e-9) << "weightless";
  world.set_gravity(Vec3(0.0, 0.0, -9.81));
  run(2000);
  EXPECT_NEAR((felt.force() - Vec3(0.0, 0.0, -kMass * 9.81)).norm(), 0.0, 1e-5);
}

// Ticks without a sample also move the tool. The next sample must not count their time again.
TEST(MassiveWorld, LosesNoTimeAndGainsNoneWithLostSamples) {
  const Scene scene = floating_ball({}, {.stiffness = 100.0});
  const auto swings = [&](int every) {
    World world(scene);
    Holder hand(world);
    hand.touch(kAbove);
    hand.memory.velocity.linear.x() = 0.2;
    for (int n = 1; n <= 300; ++n) {
      if (n % every == 0) hand.touch(kAbove, kTick * every);
      hand.push();
      EXPECT_TRUE(world.step());
    }
    return hand.memory.pose.position.x();
  };
  // The tool must be in phase with a tool that got each sample.
  EXPECT_NEAR(swings(4), swings(1), 0.02 * 0.2 * std::sqrt(kMass / 100.0));
  EXPECT_GT(std::abs(swings(1)), 0.3 * 0.2 * std::sqrt(kMass / 100.0));
}

TEST(MassiveWorld, AResetAndALeapPutTheToolToTheHandAtRest) {
  const Scene scene = floating_ball({});
  World world(scene);
  Holder hand(world);
  hand.contacts = world.contact_state(world.view(), {.force = 50.0, .speed = 2.0});
  hand.touch(kAbove);
  hand.memory.velocity.linear.x() = 0.5;
  hand.touch(kAbove);
  EXPECT_GT(hand.memory.velocity.linear.norm(), 0.4);
  const Pose far{Vec3(0.0, 1.0, 0.3), Quaternion::Identity()};
  EXPECT_LT(hand.touch(far).force().norm(), 1e-9) << "no kick";
  EXPECT_EQ(hand.memory.velocity.linear, Vec3::Zero());
  EXPECT_LT((hand.memory.pose.position - far.position).norm(), 1e-12);
}

// A client would render a local model without the tool's mass. The server must therefore compute
// the force.
TEST(MassiveWorld, HasNoLocalModel) {
  Scene scene("s", {test::object(Plane{})}, {}, {});
  const Pose down{Vec3(0.0, 0.0, 0.0095), Quaternion::Identity()};
  for (const bool mass : {false, true}) {
    scene = with_tool(std::move(scene), {});
    if (!mass) scene.set_tool({.body = std::make_shared<const BodyTool>(test::tool(400))});
    BodyMemory memory;
    scene.touch(down, Vec3::Zero(), kTick, memory);
    const BodyModel model = body_model(scene, down, memory);
    EXPECT_EQ(model.reach > 0.0, !mass);
    EXPECT_EQ(model.count > 0, !mass);
  }
}

// ToolView renders the same tool in a static scene.
TEST(MassiveWorld, InASceneInWhichNothingMoves) {
  Object plane = test::object(Plane{});
  plane.material.damping = 5.0;
  const Scene scene =
      with_tool(Scene("s", {plane}, {}, {}), {.gravity = Vec3(0.0, 0.0, -9.81), .damping = 20.0});
  BodyMemory memory;
  Command felt;
  for (int n = 0; n < 2000; ++n) felt = scene.touch(kAbove, Vec3::Zero(), kTick, memory);
  EXPECT_NEAR((felt.force() - Vec3(0.0, 0.0, -kMass * 9.81)).norm(), 0.0, 1e-6);
  // The table now carries the tool, so the hand must feel no weight.
  const Pose down{Vec3(0.0, 0.0, 0.01 - kMass * 9.81 / 1000.0), Quaternion::Identity()};
  for (int n = 0; n < 3000; ++n) felt = scene.touch(down, Vec3::Zero(), kTick, memory);
  EXPECT_LT(felt.force().norm(), 0.1 * kMass * 9.81);
}

}  // namespace
}  // namespace feltwire::massive_world_test

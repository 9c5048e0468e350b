// Tests a ball as the tool. The local model must equal the scene within the valid radius of the
// model.

#include <gtest/gtest.h>

#include <algorithm>

#include "core/grid/signed_distance.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "core/mesh/mesh_surface.hpp"
#include "core/scene/scene.hpp"
#include "tests/support/followed_hand.hpp"
#include "tests/support/meshes.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::ball_tool_test {
namespace {

using test::Random;

constexpr double kBall = 4e-3;         // [m]
constexpr double kStiffness = 1200.0;  // [N/m]
constexpr double kResolved = 1e-4;     // [m] error of a grid with 2 mm
const Material kRough{.stiffness = kStiffness,
                      .damping = 1.5,
                      .static_friction = 0.5,
                      .dynamic_friction = 0.3,
                      .viscous_friction = 0.7};

Object object_of(const Shape& shape, Side side = Side::outside) {
  Object object;
  object.name = "it";
  object.shape = shape;
  object.felt_from = side;
  object.pose = {Vec3(0.01, -0.02, 0.03), Quaternion(Eigen::AngleAxisd(0.7, Vec3(0.6, 0, 0.8)))};
  object.material = kRough;
  return object;
}

Scene scene_of(const Object& object) {
  Scene scene("one", {object});
  scene.set_tool({.radius = kBall, .body = nullptr});
  return scene;
}

struct Rolled {
  int ticks = 0, spoke = 0, touched = 0, slipped = 0, together = 0;
  double worst = 0.0;  // [N] largest error
  double slope = 0.0;  // largest error over the stiffness times the distance moved since the model
};

/// Hands approach an object from free space and then move near the object at random, with a model
/// every 20 ticks. A hand deeper than `deepest` [m] ends its run.
Rolled roll(const Object& object, Random& random, double deepest = 1.0,
            const Vec3& core = Vec3::Zero()) {
  const Scene scene = scene_of(object);
  Rolled sum;
  for (int run = 0; run < test::rounds(60); ++run) {
    test::FollowedHand hand(scene, 20);
    test::WanderingHand wanderer(random, test::led_to(hand, object, core, random), 4e-5, 8e-3);
    for (int n = 0; n < 600; ++n) {
      ++sum.ticks;
      if (!hand.step(wanderer.step())) continue;
      ++sum.spoke;
      if (hand.truth().elastic.norm() > deepest * kStiffness) break;
      const double way = kStiffness * (hand.tool().position - hand.asked()).norm();
      sum.worst = std::max(sum.worst, hand.error());
      sum.slope = std::max(sum.slope, (hand.error() - kResolved * kStiffness) /
                                          (way + hand.truth().force().norm() + 1e-9));
      if (!hand.memory()[0].touching) continue;
      ++sum.touched;
      sum.slipped += hand.memory()[0].slipping ? 1 : 0;
      sum.together += hand.model().count > 1 ? 1 : 0;
    }
  }
  return sum;
}

void expect_rolled(const Rolled& rolled, const char* name) {
  EXPECT_GT(rolled.touched, test::rounds(3000)) << name;
  EXPECT_GT(rolled.slipped, test::rounds(100)) << name;
  EXPECT_GT(rolled.spoke, rolled.ticks / 3) << name;
}

// Some solids keep their kind when they grow by a radius. A ball's model must then be as exact as a
// point's, including friction.
TEST(BallTool, SolidsThatGrowAreExact) {
  struct TouchedShape {
    const char* name;
    Shape shape;
    Side side;
  };
  const std::vector<TouchedShape> felt = {{"plane", Plane{}, Side::outside},
                                          {"ball", Sphere{0.05}, Side::outside},
                                          {"hollow ball", Sphere{0.05}, Side::inside},
                                          {"room", Box{Vec3(0.05, 0.04, 0.03)}, Side::inside},
                                          {"capsule", Capsule{0.02, 0.04}, Side::outside},
                                          {"hollow capsule", Capsule{0.03, 0.04}, Side::inside},
                                          {"hollow can", Cylinder{0.04, 0.03}, Side::inside}};
  Random random(1);
  for (const TouchedShape& it : felt) {
    const Rolled rolled = roll(object_of(it.shape, it.side), random);
    EXPECT_LT(rolled.worst, 1e-8) << it.name;
    expect_rolled(rolled, it.name);
  }
}

// Boxes and cylinders get round edges.
TEST(BallTool, RoundEdgesAreExact) {
  Random random(2);
  const Rolled box = roll(object_of(Box{Vec3(0.05, 0.04, 0.02)}), random, 0.9 * kBall);
  EXPECT_LT(box.worst, 1e-8);
  expect_rolled(box, "box");
  EXPECT_GT(box.together, test::rounds(1000));
  const Rolled can = roll(object_of(Cylinder{0.04, 0.03}), random, 0.9 * kBall);
  EXPECT_LT(can.worst, 1e-8);
  expect_rolled(can, "can");
}

// Patches only approximate these shapes. The error grows with the hand's distance from the model's
// position.
TEST(BallTool, OthersAreFitted) {
  Random random(3);
  const Vec3 core(0.05, 0.0, 0.0);
  for (const Side side : {Side::outside, Side::inside}) {
    const auto dry = [&](const Shape& shape, const Vec3& middle = Vec3::Zero()) {
      Object object = object_of(shape, side);
      object.material.static_friction = object.material.dynamic_friction = 0.0;
      const Rolled rolled = roll(object, random, 0.9 * kBall, middle);
      EXPECT_LT(rolled.slope, 2.0 * kPatchSlope) << shape.index();
      EXPECT_GT(rolled.touched, test::rounds(1000)) << shape.index();
      EXPECT_GT(rolled.spoke, rolled.ticks / 5) << shape.index();
    };
    dry(Cone{0.05, 0.04});
    dry(Torus{0.05, 0.02}, core);
    dry(Grid{std::make_shared<DistanceGrid<float>>(solid_of(Sphere{0.05}),
                                                   GridOptions{.resolution = 2e-3})});
  }
}

// A mesh adds the tool's radius to its own.
TEST(BallTool, OnAMeshItIsTheMeshsOwnBall) {
  Random random(4);
  const Vec3 half(0.05, 0.04, 0.03);
  const auto mesh = [&](double radius) {
    return test::mesh_object(test::box(half, 2), {.radius = radius}, kRough);
  };
  const Scene thick("thick", {mesh(3.0 * kBall)});
  const Scene both = scene_of(mesh(2.0 * kBall));  // including the tool's radius
  for (int i = 0; i < 500; ++i) {
    TouchMemory a = thick.memory(), b = both.memory();
    const Vec3 from = 0.15 * random.direction();
    Vec3 place;
    for (double t = 1.0; t > 0.0; t -= 0.01) {
      place = t * from;
      const Command force = thick.touch({place, Vec3::Zero()}, a);
      EXPECT_LT((both.touch({place, Vec3::Zero()}, b).force() - force.force()).norm(), 1e-9);
      if (!force.elastic.isZero(0.0)) break;
    }
    const LocalModel one = local_model(thick, place, a), other = local_model(both, place, b);
    ASSERT_EQ(one.count, other.count);
    ASSERT_NEAR(one.reach, other.reach, 1e-9);
    for (int k = 0; k < one.count; ++k) {
      ASSERT_EQ(one.patches[static_cast<std::size_t>(k)].point,
                other.patches[static_cast<std::size_t>(k)].point);
      ASSERT_NEAR(one.patches[static_cast<std::size_t>(k)].offset,
                  other.patches[static_cast<std::size_t>(k)].offset, 1e-12);
    }
  }
}

/// A client joins while the ball slides. The client must continue with the server's stick point.
TEST(BallTool, AContactThatTheServerHoldsIsTakenUp) {
  for (const Vec3& edge : {Vec3(0.0, 0.0, 0.0), Vec3(0.05, 0.0, 0.0)}) {  // a face, an edge
    Object object = object_of(Box{Vec3(0.05, 0.04, 0.02)});
    object.pose = {};
    const Scene scene = scene_of(object);
    TouchMemory memory = scene.memory();
    Command truth;
    Tool tool;
    for (int n = 0; n <= 50; ++n) {
      tool = {edge + Vec3(1e-5 * n, 2e-5 * n, 0.02 + kBall + 0.001 - 6e-5 * n), Vec3::Zero()};
      truth = scene.touch(tool, memory);
    }
    ASSERT_GT(truth.elastic.norm(), 1.0);
    ASSERT_GT(truth.frictional.norm(), 0.1);
    LocalContact late;
    late.take(local_model(scene, tool.position, memory));
    const Command here = late.touch(tool, 0.0, 1e-3).command;
    EXPECT_LT((here.elastic - truth.elastic).norm(), 1e-8);
    EXPECT_LT((here.frictional - truth.frictional).norm(), 1e-8);
  }
}

}  // namespace
}  // namespace feltwire::ball_tool_test

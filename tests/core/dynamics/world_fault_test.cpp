// A simulation becomes unstable. The scene must be reset, and the hand must feel no force.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <cmath>
#include <vector>

#include "core/dynamics/diverged_trees.hpp"
#include "core/dynamics/mujoco_buffers.hpp"
#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/dynamics/world.hpp"
#include "core/local_model_extraction/extract.hpp"
#include "tests/core/moving.hpp"

namespace feltwire::world_fault_test {
namespace {

using test::body;
using test::explosive;
using test::Hand;
using test::kWeightless;
using test::moving;
using test::object;
using ::testing::HasSubstr;

TEST(MujocoGuard, AnErrorIsAnAnswerNotTheEndOfTheProcess) {
  ASSERT_NE(mujoco::load_text("<mujoco/>").model, nullptr);
  EXPECT_FALSE(mujoco::guarded([] { mju_error("made up"); }));
  EXPECT_TRUE(mujoco::guarded([] {}));
  bool inner = true;
  EXPECT_TRUE(mujoco::guarded([&] { inner = mujoco::guarded([] { mju_error("made up"); }); }));
  EXPECT_FALSE(inner);
  EXPECT_FALSE(mujoco::guarded([] {
    mujoco::guarded([] { mju_error("made up"); });
    mju_error("again");
  }));
}

TEST(MujocoGuard, ABadModelIsAnError) {
  const mujoco::Loaded none = mujoco::load_text("<mujoco><worldbody><geom size=\"-1\"/>");
  EXPECT_EQ(none.model, nullptr);
  EXPECT_THAT(none.error, HasSubstr("XML"));
}

TEST(WorldFaults, AStiffLightBodyIsWarnedOf) {
  const auto warnings = explosive().mechanism()->warnings();
  ASSERT_EQ(warnings.size(), 1u);
  EXPECT_THAT(warnings[0], HasSubstr("object 'ball': 0.1 g"));
  EXPECT_THAT(warnings[0], HasSubstr("1e+07 N/m"));
  // k < m / T^2, m > k T^2, T < sqrt(m / k)
  EXPECT_THAT(warnings[0], HasSubstr("at most 100 N/m"));
  EXPECT_THAT(warnings[0], HasSubstr("at least 1e+04 g"));
  // 3.16e-06 s is below the shortest tick of a scene.
  EXPECT_THAT(warnings[0], HasSubstr("no tick that a scene may have is short enough"));
}

TEST(WorldFaults, TheSceneGoesBackAndTheHandFeelsZero) {
  const Scene scene = explosive();
  World world(scene);
  Hand hand(world);
  const Vec3 place(0, 0, 0.2 - 0.0295);
  for (int n = 0; n < 400; ++n) ASSERT_TRUE(world.step());
  EXPECT_NE(hand.touch(place).force(), Vec3::Zero());
  int steps = 0;
  while (world.counters().resets == 0 && ++steps < 100) hand.step(place);
  ASSERT_EQ(world.counters().resets, 1u);
  EXPECT_NEAR((world.objects()[1].pose.position - Vec3(0, 0, 0.2)).norm(), 0.0, 1e-12);
  EXPECT_EQ(world.velocity_at(1, place), Vec3::Zero());
  EXPECT_EQ(hand.touch(place).force(), Vec3::Zero());
  // Static objects must give the same force as before.
  EXPECT_EQ(hand.touch({0.1, 0, -0.001}).elastic, Vec3(0, 0, 1));
  // The force must then return gradually. The full force has 500 N/mm.
  hand.touch(place);
  for (int n = 0; n < 10; ++n) world.step();
  const double felt = hand.touch(place).force().norm();
  EXPECT_NEAR(felt, 10 * kDefaultTick / World::kRecovery * 1e7 * 5e-4, 1e-6);
}

// A hand's push must end with a reset, whether the hand is near or far.
TEST(WorldFaults, NoPushOutlivesAReset) {
  const Scene scene = explosive();
  for (const double beside : {0.05, 0.5}) {
    World world(scene);
    Hand hand(world);
    for (int n = 0; world.counters().resets == 0 && n < 500; ++n) hand.step({0, 0, 0.1705});
    ASSERT_EQ(world.counters().resets, 1u);
    EXPECT_EQ(hand.step({beside, 0, 0.2}).force(), Vec3::Zero());
    EXPECT_EQ(world.momentum(), Vec3::Zero());
  }
}

// A client that renders the force itself must also get none.
TEST(WorldFaults, TheLocalModelGoesSoftWithTheScene) {
  const Scene scene = explosive();
  World world(scene);
  Hand hand(world);
  const Vec3 place(0, 0, 0.2 - 0.0305);  // between ball and table, near both
  EXPECT_FALSE(world.recovering());
  const auto stiffness = [&](std::size_t object) {
    const LocalModel model = local_model(world, place, hand.memory);
    for (const SurfacePatch& patch : model.view())
      if (patch.object == object) return patch.material.stiffness;
    return 0.0;
  };
  EXPECT_EQ(stiffness(1), 1e7);
  for (int n = 0; world.counters().resets == 0 && n < 500; ++n) hand.step({0, 0, 0.1705});
  ASSERT_EQ(world.counters().resets, 1u);
  EXPECT_TRUE(world.recovering());
  EXPECT_GT(stiffness(1), 0.0);
  EXPECT_LE(stiffness(1), 10.0);
  for (int n = 0; n < 100; ++n) world.step();
  EXPECT_NEAR(stiffness(1), 1e7 * 100 * kDefaultTick / World::kRecovery, 1.0);
  for (int n = 0; n < 400; ++n) world.step();
  EXPECT_FALSE(world.recovering());
  EXPECT_EQ(stiffness(1), 1e7);
}

/// A fault includes all bodies that touch the diverged body, directly or through other bodies. A
/// static object must not connect them.
TEST(WorldFaults, WhatTouchesWhatBrokeBelongsToIt) {
  const auto box = [](const char* name, const Vec3& at) {
    return object(name, Box{Vec3::Constant(0.02)}, {.stiffness = 1000}, at);
  };
  const Vec3 low(0, 0, 0.0199), middle(0, 0, 0.0598), top(0, 0, 0.0997), apart(0.5, 0, 0.0199);
  const Scene scene = moving({object("table", Plane{}), box("low", low), box("middle", middle),
                              box("top", top), box("apart", apart)},
                             {-1, 0, 1, 2, 3},
                             {body("low", 1.0, low), body("middle", 1.0, middle),
                              body("top", 1.0, top), body("apart", 1.0, apart)});
  const mujoco::Simulation simulation(scene.mechanism()->model());
  DivergedTrees broken(scene.mechanism()->model());
  broken.remember(*simulation.data());
  const auto& parts = scene.mechanism()->parts();
  broken.mark(parts[2].body);
  broken.spread();
  EXPECT_TRUE(broken.has(parts[0].body));
  EXPECT_TRUE(broken.has(parts[1].body));
  EXPECT_TRUE(broken.has(parts[2].body));
  EXPECT_FALSE(broken.has(parts[3].body));
  broken.clear();
  EXPECT_FALSE(broken.has(parts[2].body));
}

/// The hand that pushed the diverged body is the cause, and the report has its force. Hands on
/// other bodies, and hands that left long before, are no cause.
TEST(WorldFaults, WhoPushedWhatBrokeIsToBlame) {
  const Material soft{.stiffness = 1000};
  const Scene scene = moving(
      {object("table", Plane{}, soft),
       object("ball", Sphere{0.03}, {.stiffness = 1e7}, {0, 0, 0.2}),
       object("calm", Sphere{0.03}, soft, {1, 0, 0.2})},
      {-1, 0, 1}, {body("ball", 1e-4, {0, 0, 0.2}), body("calm", 100.0, {1, 0, 0.2})}, kWeightless);
  World world(scene);
  Hand guilty(world), other(world), gone(world);
  for (int n = 0; n < 500; ++n) {
    if (n < 300) gone.touch({0, 0, 0.2 - 0.0299999999});
    if (n < 300) world.push(gone.contacts, gone.memory, 1.0);
    other.touch({1, 0, 0.171});
    world.push(other.contacts, other.memory, 1.0);
    if (n >= 450) guilty.touch(world.objects()[1].pose.position - Vec3(0, 0, 0.0295));
    if (n >= 450) world.push(guilty.contacts, guilty.memory, 1.0);
    world.step();
    if (world.counters().resets > 0) break;
  }
  ASSERT_EQ(world.counters().resets, 1u);
  EXPECT_GE(world.blame(guilty.contacts), 4999.0);
  EXPECT_EQ(world.blame(other.contacts), 0.0);
  EXPECT_EQ(world.blame(gone.contacts), 0.0);
}

// A falling ball has a different height at each step. The height therefore shows the state to which
// a reset returned. The world keeps states every 0.1 s.
TEST(WorldFaults, GoesFartherBackWhenThatWasNotGoodEnough) {
  const Vec3 start(0, 0, 20);
  const Scene scene = moving({object("table", Plane{}, {.stiffness = 1000}),
                              object("ball", Sphere{0.03}, {.stiffness = 1e7}, start)},
                             {-1, 0}, {body("ball", 1e-4, start)});
  World world(scene);
  Hand hand(world);
  const auto height = [&] { return world.objects()[1].pose.position.z(); };
  std::vector<double> fallen{height()};  // height after each step
  while (fallen.size() <= 1450) {
    ASSERT_TRUE(world.step());
    ASSERT_LT(height(), fallen.back());
    fallen.push_back(height());
  }
  std::vector<std::ptrdiff_t> went_back_to;  // [steps] state after each reset
  while (went_back_to.size() < 15) {
    const std::uint64_t resets = world.counters().resets;
    hand.touch(world.objects()[1].pose.position - Vec3(0, 0, 0.031));
    // The simulation fails again before the world has a new state that is old enough.
    for (int steps = 0; world.counters().resets == resets; ++steps) {
      ASSERT_LT(steps, 150);
      hand.step(world.objects()[1].pose.position - Vec3(0, 0, 0.0299));
    }
    went_back_to.push_back(std::find(fallen.begin(), fallen.end(), height()) - fallen.begin());
    EXPECT_EQ(world.velocity_at(1, Vec3::Zero()), Vec3::Zero());
  }
  EXPECT_THAT(went_back_to, ::testing::ElementsAre(1200, 1100, 1000, 900, 800, 700, 600, 500, 400,
                                                   300, 200, 100, 0, 0, 0));
}

TEST(WorldFaults, AToolThatIsNotFinitePushesNothing) {
  const Scene scene = explosive();
  World world(scene);
  Hand hand(world);
  for (int n = 0; n < 10; ++n) EXPECT_EQ(hand.step(Vec3(std::nan(""), 0, 0)).force(), Vec3::Zero());
  EXPECT_EQ(world.momentum(), Vec3::Zero());
}

/// A body deep in another body is an error in the scene.
TEST(WorldFaults, BodiesThatBeginInsideEachOtherAreWarnedOf) {
  const Scene scene = moving({object("table", Plane{}), object("box", Box{Vec3::Constant(0.02)})},
                             {-1, 0}, {body("box", 0.5)});
  ASSERT_EQ(scene.mechanism()->warnings().size(), 1u);
  EXPECT_THAT(scene.mechanism()->warnings()[0],
              HasSubstr("objects 'table' and 'box' begin 20 mm inside each other"));
}

TEST(WorldFaults, AMechanismOfOtherObjectsIsRefused) {
  std::vector<Object> one{object("ball", Sphere{0.1})};
  const auto mechanism = compile(one, {0}, {body("ball", 1.0)}, {});
  Scene two("s", {object("a", Sphere{0.1}), object("b", Sphere{0.1})});
  EXPECT_THROW(two.set_mechanism(mechanism), std::invalid_argument);
}

TEST(WorldFaults, RefusesWhatCannotMove) {
  const auto refused = [](const Object& o, const Body& b) -> std::string {
    std::vector<Object> objects{o};
    try {
      compile(objects, {0}, {b}, {});
    } catch (const std::invalid_argument& error) {
      return error.what();
    }
    return "no error";
  };
  const Object ball = object("ball", Sphere{0.1});
  const auto with = [&](auto change) {
    Body b = body("b", 1.0);
    change(b);
    return refused(ball, b);
  };
  EXPECT_EQ(with([](Body&) {}), "no error");
  EXPECT_THAT(with([](Body& b) { b.mass = -1.0; }), HasSubstr("body 'b': mass: must lie from"));
  EXPECT_THAT(with([](Body& b) { b.mass.reset(); }), HasSubstr("mass: is missing"));
  EXPECT_THAT(with([](Body& b) { b.density = 1.0; }), HasSubstr("mass: stands beside a density"));
  EXPECT_THAT(with([](Body& b) { b.high = 1.0; }), HasSubstr("range: is of a hinge or a slide"));
  const auto hinged = [&](auto change) {
    return with([&](Body& b) {
      b.joint = Joint::hinge;
      change(b);
    });
  };
  EXPECT_EQ(hinged([](Body&) {}), "no error");
  EXPECT_THAT(hinged([](Body& b) { b.axis.setZero(); }), HasSubstr("axis: has no direction"));
  EXPECT_THAT(hinged([](Body& b) { b.low = 1.0, b.high = 0.0; }), HasSubstr("range: must be"));
  EXPECT_THAT(hinged([](Body& b) { b.low = 0.1, b.high = 0.2; }), HasSubstr("range: must hold 0"));
  EXPECT_THAT(hinged([](Body& b) { b.damping = -1.0; }), HasSubstr("damping: must lie"));
  EXPECT_THAT(refused(object("p", Plane{}), body("b", 1.0)), HasSubstr("no volume"));
  Object hollow = ball;
  hollow.felt_from = Side::inside;
  EXPECT_THAT(refused(hollow, body("b", 1.0)), HasSubstr("felt_from: a body is a solid"));
  std::vector<Object> objects{ball};
  EXPECT_THROW(compile(objects, {-1}, {body("b", 1.0)}, {}), std::invalid_argument);
  EXPECT_THROW(compile(objects, {0}, {body("b", 1.0)}, {.tick = 1.0}), std::invalid_argument);
}

}  // namespace
}  // namespace feltwire::world_fault_test

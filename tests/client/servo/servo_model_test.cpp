// Tests the servo's forces from a local model between the replies.

#include <gtest/gtest.h>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::servo_model_test {
namespace {

using namespace testing::servo;

SessionParameters modelled(std::string_view mode = "none") {
  SessionParameters p = parameters(mode);
  p.local_model = true;
  return p;
}

/// Returns a reply with a floor at z = 0. Its local model is valid within 40 mm of the tool.
Reply floor_reply(std::uint64_t index, double z, double stiffness = 1000.0) {
  Reply r = reply(index, elastic(0, 0, 7));  // No tick at another height may use this force.
  r.modelled = true;
  r.model.center = {0, 0, z};
  r.model.reach = 0.04;
  r.model.count = 1;
  SurfacePatch& floor = r.model.patches[0];
  floor.point = {0, 0, 0};
  floor.radius = 0.1;
  floor.material.stiffness = stiffness;
  return r;
}

TEST(ServoModel, RendersTheModelWhereTheDeviceIsNow) {
  Bench bench(modelled());
  bench.tick(at(0, 0, 1e-3));
  bench.servo.take(floor_reply(1, 1e-3), bench.now);
  EXPECT_EQ(bench.tick(at(0, 0, 1e-3)).force(), Vec3::Zero());  // no contact yet
  for (const double depth : {1e-4, 1e-3, 2e-3, 5e-4}) {
    const Command given = bench.tick(at(1e-3, 0, -depth));
    EXPECT_NEAR(given.elastic.z(), 1000.0 * depth, 1e-12);
    EXPECT_EQ(bench.servo.command().elastic, given.elastic);
  }
  EXPECT_EQ(bench.servo.statistics().local_model.from_model, 5u);
  EXPECT_EQ(bench.servo.statistics().local_model.received, 1u);
  EXPECT_EQ(bench.servo.statistics().local_model.patches, 1u);
}

TEST(ServoModel, FadesAsCommandsDo) {
  SessionParameters p = modelled();
  p.hold_time = 0.1;
  for (const auto& [age, factor] : {std::pair{0.04, 1.0}, {0.06, 0.8}, {0.075, 0.5}, {0.11, 0.0}}) {
    Bench bench(p);
    bench.tick();
    bench.servo.take(floor_reply(1, 0.0), bench.now);
    EXPECT_NEAR(bench.tick(at(0, 0, -2e-3), seconds(age)).elastic.z(), 2.0 * factor, 1e-9) << age;
  }
}

// Over the last quarter of the model's radius, the force blends into the reply's command without a
// step.
TEST(ServoModel, HandsOverToTheReplyWithoutAStep) {
  Bench bench(modelled());
  bench.tick();
  const Reply sent = floor_reply(1, 0.0);
  bench.servo.take(sent, bench.now);
  double before = 0.0;
  bool beyond = false;
  for (double x = 0.0; x < 0.05; x += 1e-5) {
    const double given = bench.tick(at(x, 0, -1e-3), Nanoseconds(1)).elastic.z();
    const double distance = std::hypot(x, 1e-3);
    if (distance < 0.03) {
      EXPECT_NEAR(given, 1.0, 1e-12);
    }
    if (distance > 0.04) {
      EXPECT_EQ(given, sent.command.elastic.z());
      beyond = true;
    }
    if (x > 0.0) {
      EXPECT_LT(std::abs(given - before), 6.0 * 1e-5 / 0.01 * 1.001) << x;
    }
    before = given;
  }
  EXPECT_TRUE(beyond);
  EXPECT_GT(bench.servo.statistics().local_model.from_both, 900u);
  EXPECT_GT(bench.servo.statistics().local_model.beyond_reach, 900u);
}

TEST(ServoModel, AReplyWithoutOneEndsIt) {
  Bench bench(modelled());
  bench.tick();
  bench.servo.take(floor_reply(1, 0.0), bench.now);
  bench.tick(at(0, 0, -1e-3));
  bench.servo.take(reply(2, elastic(0, 3, 0)), bench.now);
  EXPECT_EQ(bench.tick(at(0, 0, -1e-3)).elastic, Vec3(0, 3, 0));
  bench.servo.take(floor_reply(3, 0.0), bench.now);
  EXPECT_NEAR(bench.tick(at(0, 0, -1e-3)).elastic.z(), 1.0, 1e-12);
  bench.servo.reconnected(true);  // A lost session must also drop the model, after a fade.
  double before = 1.0;
  for (int i = 0; i < 50; ++i) {
    const double now = bench.tick(at(0, 0, -1e-3)).elastic.z();
    EXPECT_LT(now, before);
    before = now;
  }
  EXPECT_EQ(before, 0.0);
  bench.servo.take(reply(bench.servo.sample().index, elastic(0, 3, 0)), bench.now);
  EXPECT_GT(bench.tick(at(0, 0, -1e-3)).elastic.y(), 0.0);
  EXPECT_EQ(bench.servo.held().elastic.z(), 0.0);
}

TEST(ServoModel, WithoutLocalModelItIsNotLookedAt) {
  Bench bench(parameters("none"));
  bench.tick();
  bench.servo.take(floor_reply(1, 0.0), bench.now);
  EXPECT_EQ(bench.tick(at(0, 0, -1e-3)).elastic.z(), 7.0);
}

// The local model gives the scene's own force, even if the server's bound reduces the force in the
// replies.
TEST(ServoModel, EndsTheWaitForSmallForce) {
  ServoOptions options;
  options.safety.force.small = 0.05;
  Bench bench(modelled(), options);
  bench.tick(at(0, 0, -2e-3));
  Reply r = floor_reply(1, -2e-3);
  r.bound.active = true;
  bench.servo.take(r, bench.now);
  // The hand began inside and must wait.
  EXPECT_EQ(bench.tick(at(0, 0, -2e-3)).force(), Vec3::Zero());
  EXPECT_EQ(bench.tick(at(0, 0, 0.2e-3)).force(), Vec3::Zero());  // The hand is outside.
  EXPECT_NEAR(bench.tick(at(0, 0, -1e-3)).elastic.z(), 1.0, 1e-12);
}

// A conveyor rises at 0.1 m/s. The servo must render the floor at its present height.
TEST(ServoModel, MovesSurfacesByTheAgeOfTheirState) {
  Bench bench(modelled());
  bench.tick();
  Reply r = floor_reply(1, 0.0);
  r.model.patches[0].velocity = {0, 0, 0.1};
  // The round trip is 8 ms. The server's state is therefore 4 ms old when the reply arrives.
  r.server_times.received = r.server_times.sent = seconds(50.0);
  for (int i = 0; i < 8; ++i) bench.tick();
  bench.servo.take(r, bench.now);
  const double age = 4e-3 + 1e-3;
  EXPECT_NEAR(bench.tick(at(0, 0, 0)).elastic.z(), 1000.0 * 0.1 * age, 1e-9);
}

TEST(ServoModel, DampingAndViscosityGoByTheVelocityHere) {
  Bench bench(modelled());
  bench.tick(at(0, 0, -1e-3));
  Reply r = floor_reply(1, -1e-3);
  r.model.patches[0].material.damping = 2.0;
  r.model.patches[0].material.viscous_friction = 3.0;
  bench.servo.take(r, bench.now);
  // velocity: 0.2 m/s tangential, 0.1 m/s into the floor
  const Command given = bench.tick(at(2e-4, 0, -1.1e-3));
  EXPECT_NEAR(given.elastic.z(), 1.1, 1e-12);
  EXPECT_NEAR(given.frictional.x(), -3.0 * 0.2, 1e-9);
  EXPECT_NEAR(given.frictional.z(), 2.0 * 0.1, 1e-9);
}

}  // namespace
}  // namespace feltwire::servo_model_test

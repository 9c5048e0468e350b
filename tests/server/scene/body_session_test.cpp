// Tests a session of a tool with a body. The session gets the orientation and returns torque if the
// device supports them.

#include <gtest/gtest.h>

#include "core/scene_file/load_scene.hpp"
#include "server/scene/session.hpp"
#include "tests/server/make.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::body_session_test {
namespace {

Scene scene() {
  return parse_scene(R"({
    "name": "desk", "materials": [{ "name": "m", "stiffness": 1000 }],
    "objects": [{ "name": "top", "plane": {}, "material": "m" }],
    "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 500 } } })",
                     "desk.json");
}

control::JoinRequest request(int rotation) {
  control::JoinRequest r = test::join_request();
  r.device.rotation_sensed = rotation;
  r.device.rotation_actuated = rotation;
  r.device.rotational_damping = rotation > 0 ? 1e-3 : 0.0;
  r.device.max_torque = rotation > 0 ? 0.5 : 0.0;
  return r;
}

/// Returns a sample of a hand that lowers a box onto the desk. The box is tilted by `angle` about
/// y.
SampleBatch lowered(std::uint64_t index, double angle, bool rotation) {
  SampleBatch batch;
  batch.count = 1;
  batch.rotation = rotation;
  batch.previous = index - 1;
  Sample& sample = batch.samples[0];
  sample.index = index;
  sample.client_time = std::chrono::milliseconds(index);
  sample.pose.position.z() = 0.013 - 2e-5 * static_cast<double>(index);
  if (rotation) sample.pose.orientation = Quaternion(Eigen::AngleAxisd(angle, Vec3::UnitY()));
  return batch;
}

// The client bounds, so these answers are the scene's forces. (The torque channel of a server's
// bound has a separate account. This account gives no torque until the hand has rotated against the
// torque.)
TEST(BodySession, ATiltedBoxTurnsTheHandBack) {
  const Scene desk = scene();
  for (const double angle : {0.1, -0.1}) {
    control::JoinRequest client_bounds = request(3);
    client_bounds.parameters.side = BoundingSide::client;
    Session session(client_bounds, desk);
    Reply reply;
    for (std::uint64_t i = 1; i <= 300; ++i)
      reply = session.take(lowered(i, angle, true), Nanoseconds{0}).reply;
    EXPECT_TRUE(reply.rotation);
    EXPECT_GT(reply.command.elastic.z(), 0.01);
    EXPECT_LT(reply.command.torque.y() * angle, -1e-5);
    EXPECT_NEAR(reply.command.torque.x(), 0.0, 0.1 * std::abs(reply.command.torque.y()));
  }
}

TEST(BodySession, ADeviceWithoutRotationGetsTheForceAlone) {
  const Scene desk = scene();
  Session session(request(0), desk);
  Reply reply;
  for (std::uint64_t i = 1; i <= 300; ++i)
    reply = session.take(lowered(i, 0.0, false), Nanoseconds{0}).reply;
  EXPECT_FALSE(reply.rotation);
  EXPECT_EQ(reply.command.torque, Vec3::Zero());
  EXPECT_GT(reply.command.elastic.z(), 0.1);
}

// The hand must feel the weight of a tool with mass. A client would render a model of this tool
// without mass, so the server must send no model.
TEST(BodySession, AToolWithMassWeighsAndHasNoModel) {
  const Scene heavy = parse_scene(R"({
    "name": "desk", "materials": [{ "name": "m", "stiffness": 1000 }],
    "objects": [{ "name": "top", "plane": {}, "position": [0, 0, -1], "material": "m" }],
    "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 500, "mass": 0.2,
      "coupling": { "damping": 20 } } } })",
                                  "desk.json");
  control::JoinRequest client_bounds = request(3);
  client_bounds.parameters.side = BoundingSide::client;
  client_bounds.parameters.local_model = true;
  Session session(client_bounds, heavy);
  Reply reply;
  for (std::uint64_t i = 1; i <= 1000; ++i) {
    SampleBatch still = lowered(i, 0.0, true);
    still.samples[0].pose.position.z() = 0.1;
    reply = session.take(still, Nanoseconds{0}).reply;
    EXPECT_FALSE(reply.body_modelled);  // The client would drop an empty model.
  }
  EXPECT_NEAR((reply.command.force() - Vec3(0.0, 0.0, -0.2 * 9.81)).norm(), 0.0, 1e-6);
  EXPECT_EQ(reply.command.elastic, Vec3::Zero());
}

control::JoinRequest modelled() {
  control::JoinRequest client_bounds = request(3);
  client_bounds.parameters.side = BoundingSide::client;
  client_bounds.parameters.local_model = true;
  return client_bounds;
}

// A client with the complete tool and solids must get the tool's pose and no planes, until a
// material changes.
TEST(BodySession, AClientThatHasTheSolidsGetsNoPlanes) {
  Scene desk = scene();
  Session session(modelled(), desk);
  const auto model = [&](std::uint64_t index) {
    const Reply reply = session.take(lowered(index, 0.1, true), Nanoseconds{0}).reply;
    EXPECT_TRUE(reply.body_modelled);
    return reply.body;
  };
  EXPECT_GT(model(1).count, 0);
  EXPECT_TRUE(session.take_surfaces(5, {1}).has_value());  // Object 5 does not exist.
  EXPECT_EQ(model(2).solids, 0u);
  EXPECT_EQ(session.take_surfaces(5, {0}), std::nullopt);
  EXPECT_EQ(model(3).solids, 5u);
  EXPECT_EQ(model(4).count, 0);
  Scene other = desk;
  other.set_material(0, {.stiffness = 500.0});
  session.adopt(other, 0);
  EXPECT_EQ(model(5).solids, 0u);
  EXPECT_GT(model(6).count, 0);
}

// A client with the solids may get a model of a tool with mass. A change of gravity must end the
// model.
TEST(BodySession, AToolWithMassHasAModelOnceItsClientHasIt) {
  const Scene heavy = parse_scene(R"({
    "name": "desk", "materials": [{ "name": "m", "stiffness": 1000 }],
    "objects": [{ "name": "top", "plane": {}, "material": "m" }],
    "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 500, "mass": 0.2 } } })",
                                  "desk.json");
  Session session(modelled(), heavy);
  const auto reply = [&](std::uint64_t index) {
    return session.take(lowered(index, 0.1, true), Nanoseconds{0}).reply;
  };
  EXPECT_FALSE(reply(1).body_modelled);
  EXPECT_EQ(session.take_surfaces(7, {0}), std::nullopt);
  const Reply modelled = reply(2);
  EXPECT_TRUE(modelled.body_modelled);
  EXPECT_EQ(modelled.body.solids, 7u);
  session.weigh_anew();
  const Reply weighed = reply(3);
  EXPECT_FALSE(weighed.body_modelled);
  // The new number makes the client send a new request.
  EXPECT_NE(weighed.reloads, modelled.reloads);
}

TEST(BodySession, NeverAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  const Scene desk = scene();
  Session session(request(3), desk);
  const std::size_t before = test::allocations();
  for (std::uint64_t i = 1; i <= 300; ++i) session.take(lowered(i, 0.1, true), Nanoseconds{0});
  EXPECT_EQ(test::allocations(), before);
}

}  // namespace
}  // namespace feltwire::body_session_test

// Tests a session's local model over the wire. The server makes it, the wire rounds it to float32,
// and a client must render the force of the scene.

#include <gtest/gtest.h>

#include "core/scene_file/load_scene.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/guard.hpp"
#include "server/scene/session.hpp"
#include "tests/support/followed_hand.hpp"

namespace feltwire::model_session_test {
namespace {

using test::Random;

Scene room() { return load_scene(std::string(FELTWIRE_SOURCE_DIR) + "/scenes/room.json"); }

control::JoinRequest request(bool local_model) {
  control::JoinRequest r;
  r.client = "tester";
  r.scene = "room";
  r.device = builtin_device("simulated");
  r.parameters.side = BoundingSide::client;
  r.parameters.local_model = local_model;
  return r;
}

SampleBatch sample(std::uint64_t index, const Vec3& position) {
  SampleBatch batch;
  batch.count = 1;
  batch.samples[0].index = index;
  batch.samples[0].client_time = std::chrono::milliseconds(index);
  batch.samples[0].pose.position = position;
  return batch;
}

TEST(ModelSession, OnlyWhoAsksForItGetsOne) {
  const Scene scene = room();
  Session plain(request(false), scene), modelled(request(true), scene);
  const Vec3 over_table(0.0, 0.0, -0.045);
  EXPECT_FALSE(plain.take(sample(1, over_table), {}).reply.modelled);
  const Reply reply = modelled.take(sample(1, over_table), {}).reply;
  ASSERT_TRUE(reply.modelled);
  EXPECT_EQ(reply.model.center, over_table);
  ASSERT_GE(reply.model.count, 1);
  EXPECT_NEAR(reply.model.patches[0].point.z(), -0.05, 1e-12);

  SessionParameters off = request(false).parameters;
  modelled.set_parameters(off);
  EXPECT_FALSE(modelled.take(sample(2, over_table), {}).reply.modelled);
}

// A reload brings other surfaces with equal names. The client must not continue the old contacts.
TEST(ModelSession, EachSceneThatItEntersHasANumberOfItsOwn) {
  const Scene scene = room(), again = room();
  Session session(request(true), scene);
  const Vec3 over_table(0.0, 0.0, -0.045);
  const std::uint32_t first = session.take(sample(1, over_table), {}).reply.model.scene;
  EXPECT_EQ(session.take(sample(2, over_table), {}).reply.model.scene, first);
  session.enter(Session::Place(again, nullptr));
  EXPECT_NE(session.take(sample(3, over_table), {}).reply.model.scene, first);
}

Object wall(const char* name, const Vec3& normal) {
  Object plane;
  plane.name = name;
  plane.shape = Plane{};
  plane.pose.orientation = turn_to(Vec3::UnitZ(), normal);
  return plane;
}

Object hollow_box() {
  Object box;
  box.name = "room";
  box.shape = Box{Vec3::Constant(0.1)};
  box.felt_from = Side::inside;
  box.pose.position = Vec3::Constant(0.1);
  return box;
}

TEST(ModelSession, WhoShapesIsToldTheWallsOfACorner) {
  const Scene planes(
      "planes", {wall("x", Vec3::UnitX()), wall("y", Vec3::UnitY()), wall("z", Vec3::UnitZ())});
  const Scene hollow("hollow", {hollow_box()});
  for (const Scene* scene : {&planes, &hollow}) {
    control::JoinRequest asked = request(false);
    asked.parameters.mode = kSessionMethod;
    Session session(asked, *scene);
    EXPECT_EQ(session.take(sample(1, Vec3::Constant(0.05)), {}).reply.normals.count, 0);
    const Reply two = session.take(sample(2, {-1e-3, -2e-3, 0.05}), {}).reply;
    ASSERT_EQ(two.normals.count, 2);
    const Reply three = session.take(sample(3, {-1e-3, -2e-3, -3e-3}), {}).reply;
    ASSERT_EQ(three.normals.count, 3);
    for (const Reply* reply : {&two, &three}) {
      // starts as the command, minus the part along each wall's normal
      Vec3 across = reply->command.elastic;
      for (int i = 0; i < reply->normals.count; ++i) {
        const Vec3& normal = reply->normals.unit[static_cast<std::size_t>(i)];
        EXPECT_NEAR(normal.maxCoeff(), 1.0, 1e-12);
        EXPECT_GT(normal.dot(reply->command.elastic), 0.0);
        across -= normal.dot(reply->command.elastic) * normal;
      }
      EXPECT_LT(across.norm(), 1e-9);
    }
    SessionParameters bounds = asked.parameters;
    bounds.mode = kDefaultMethod;
    session.set_parameters(bounds);
    EXPECT_EQ(session.take(sample(4, {-1e-3, -2e-3, -3e-3}), {}).reply.normals.count, 0);
  }
}

// Hands move near the surfaces of the room. Every 20 ms a model passes through the codec.
TEST(ModelSession, OverTheWireItIsTheSceneToFloatPrecision) {
  const Scene scene = room();
  Random random(6);
  Encoder encoder;
  int touched = 0, ticks = 0, spoke = 0;
  double worst = 0.0;  // [N] largest error
  for (int run = 0; run < 60; ++run) {
    Session session(request(true), scene);
    test::FollowedHand hand(scene, 20);
    const Vec3 place(random.uniform(-0.11, 0.11), random.uniform(-0.11, 0.11), -0.0505);
    test::WanderingHand wanderer(random, place);
    Reply sent;
    const auto received = [&](const Vec3&) {
      const Bytes payload = encoder.reply(sent);
      EXPECT_LE(payload.size() + kOverhead, 640u);
      Reply reply;
      EXPECT_EQ(decode(payload, reply), DropReason::none);
      return reply.model;
    };
    for (int n = 1; n <= 600; ++n) {
      const Tool tool = wanderer.step();
      ++ticks;
      if (hand.step(tool, received)) {
        ++spoke;
        touched += hand.truth().elastic.norm() > 0.0 ? 1 : 0;
        worst = std::max(worst, hand.error());
      }
      sent = session.take(sample(static_cast<std::uint64_t>(n), tool.position), {}).reply;
    }
  }
  // float32 stores 0.1 m with an error of 4 nm, or 6 uN at 1500 N/m. Friction and damping add an
  // equal error.
  EXPECT_LT(worst, 5e-5);
  EXPECT_GT(worst, 0.0);
  EXPECT_GT(touched, 5000);
  EXPECT_GT(spoke, ticks / 2);
}

}  // namespace
}  // namespace feltwire::model_session_test

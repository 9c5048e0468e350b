// A session's local model over the wire: made by the server, in float32 on the way, rendered by a
// client as the scene itself.

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

// A reload brings other surfaces of the same names: nothing on the client's side goes on.
TEST(ModelSession, EachSceneThatItEntersHasANumberOfItsOwn) {
  const Scene scene = room(), again = room();
  Session session(request(true), scene);
  const Vec3 over_table(0.0, 0.0, -0.045);
  const std::uint32_t first = session.take(sample(1, over_table), {}).reply.model.scene;
  EXPECT_EQ(session.take(sample(2, over_table), {}).reply.model.scene, first);
  session.enter(Session::Place(again, nullptr));
  EXPECT_NE(session.take(sample(3, over_table), {}).reply.model.scene, first);
}

// Hands about places on the room's surfaces, a model every 20 ms through the codec.
TEST(ModelSession, OverTheWireItIsTheSceneToFloatPrecision) {
  const Scene scene = room();
  Random random(6);
  Encoder encoder;
  int touched = 0, ticks = 0, spoke = 0;
  double worst = 0.0;  // [N]
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
  // 0.1 m in float32 is right to 4 nm, which 1500 N/m makes 6 uN; friction and damping as much.
  EXPECT_LT(worst, 5e-5);
  EXPECT_GT(worst, 0.0);
  EXPECT_GT(touched, 5000);
  EXPECT_GT(spoke, ticks / 2);
}

}  // namespace
}  // namespace feltwire::model_session_test

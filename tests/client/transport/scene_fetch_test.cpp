// A client fetches the meshes or solids of its scene during rendering. The test uses a complete
// server and real sockets.

#include "client/transport/scene_fetch.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "core/mesh/mesh_surface.hpp"
#include "core/mesh/tessellation.hpp"
#include "core/scene_file/load_scene.hpp"
#include "tests/client/loopback.hpp"
#include "tests/client/peer.hpp"

namespace feltwire::scene_fetch_test {
namespace {

using namespace std::chrono_literals;
using testing::Client;

/// The clock does not advance. A busy machine therefore does not count as slow.
const SceneFetchOptions kQuick{.servo_period = 1e-3, .clock = [] { return Nanoseconds(0); }};

/// The hand rests over a ball of 5120 triangles until the test ends.
constexpr const char* kRest = "t,x,y,z\n0,0.03,0,0.046\n600,0.03,0,0.046\n";

Scene ball_scene() {
  Object ball;
  ball.name = "ball";
  ball.shape = Mesh{std::make_shared<MeshSurface>(TriangleMesh(icosphere(0.05, 4)))};
  return Scene("ball", {ball});
}

#ifdef FELTWIRE_SANITIZED
constexpr std::size_t kSolids = 1;  // With a sanitizer, the grid of a mesh takes minutes.
#else
constexpr std::size_t kSolids = 2;
#endif

/// A box of 2500 points in three parts, with a ring and a bunny as solids.
Scene ring_scene() {
  const std::string bunny =
      kSolids > 1 ? R"(, { "name": "bunny", "mesh": { "file": "bunny.obj", "scale": 0.01 },
                           "position": [0, 0.3, 0], "material": "m" })"
                  : "";
  return parse_scene(R"({ "name": "ring",
    "materials": [{ "name": "m", "stiffness": 500, "static_friction": 0.4, "dynamic_friction": 0.3 }],
    "objects": [{ "name": "ring", "torus": { "major_radius": 0.05, "minor_radius": 0.02 }, "material": "m" })" +
                         bunny + R"(],
    "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 2500 } } })",
                     FELTWIRE_SOURCE_DIR "/scenes/ring.json");
}

SessionParameters modelled() {
  SessionParameters parameters;
  parameters.side = BoundingSide::client;
  parameters.local_model = true;
  return parameters;
}

/// Holds the statuses of a client, and outlives its thread.
struct Statuses {
  Ring<LiveStatus> statuses{16};
};
/// A client that renders the fetched geometry.
struct FeelingClient : Statuses, Client {
  FeelingClient(const ServerAccess& server, const char* scene, Ring<const FetchedScene*>& fetched)
      : Client(server, kRest, modelled(), scene) {
    const LoopOptions options{.silence_timeout = testing::kPatience, .fetched = &fetched};
    thread = std::thread([this, options] {
      run_servo_loop(device, servo, transport, options, stop,
                     {.status = &statuses, .record = &records}, *result);
    });
  }
  /// Waits until the client has rendered a fetched scene for kTicks. The first model may be older
  /// than the fetched scene.
  LiveStatus renders(SceneFetch& fetch) {
    constexpr std::uint64_t kTicks = 500;
    LiveStatus status;
    std::optional<std::uint64_t> since;  // [samples]
    test::eventually("the servo renders what was fetched", [&] {
      while (statuses.pop(status)) fetch.in_use(status.scene.fetched);
      if (!since && status.scene.fetched != nullptr && status.near) since = status.samples;
      return since && status.near && status.samples >= *since + kTicks;
    });
    return status;
  }
};

class SceneFetchTest : public ::testing::Test {
 protected:
  SceneFetchTest() {
    std::vector<Scene> scenes;
    scenes.push_back(ball_scene());
    scenes.push_back(testing::floor_scene());
    scenes.push_back(ring_scene());
    ServerConfig config = testing::any_ports();
    config.silence_timeout = 60.0;  // [s] a busy machine may keep the client waiting for seconds
    server = std::make_unique<Server>(config, std::move(scenes), test::security());
    endpoint = test::access(server->control_port());
  }
  /// Calls the fetch until the condition holds. The clock advances by an hour per call, so nothing
  /// waits.
  template <class Until>
  void look(SceneFetch& fetch, const ScenePlace& place, const char* what, Until until) {
    test::eventually(what, [&] {
      fetch.look(place, now += 1h);
      return until();
    });
  }
  std::unique_ptr<Server> server;
  ServerAccess endpoint;
  SceneFetch::Clock::time_point now{};
  Ring<const FetchedScene*> ready{4};
};

TEST_F(SceneFetchTest, FeelsTheWholeMeshFromThenOn) {
  FeelingClient client(endpoint, "ball", ready);
  ASSERT_TRUE(client.joined.accepted.lists_surfaces);
  SceneFetch fetch(endpoint, ready, kQuick);
  look(fetch, {client.joined.accepted.session, 0}, "the server knows of the surface",
       [&] { return fetch.known() == 1; });
  const LiveStatus status = client.renders(fetch);
  // The client must not send a second request while the scene stays.
  for (int i = 0; i < 10; ++i) fetch.look({client.joined.accepted.session, 0}, now += 1h);
  EXPECT_FALSE(fetch.asking());
  // After a change that keeps the shapes, the client sends a request but fetches nothing.
  look(fetch, {client.joined.accepted.session, 1}, "a question", [&] { return fetch.asking(); });
  look(fetch, {client.joined.accepted.session, 1}, "its answer", [&] { return !fetch.asking(); });
  EXPECT_EQ(fetch.known(), 1u);
  client.stop.set();
  client.finish();
  EXPECT_GT(client.servo.statistics().local_model.whole, 0u);
  const FetchedScene* more = nullptr;
  EXPECT_FALSE(ready.pop(more));
  EXPECT_TRUE(status.scene.fetched->surfaces->has(0));
  EXPECT_EQ(status.scene.fetched->most_work, units_within(contact_budget(1e-3)));
  EXPECT_EQ(fetch.refusal(), "");
  EXPECT_EQ(status.contact_cuts, 0u);
}

/// On a slow machine the servo must not get the surface, and the user gets a message. The server
/// still sends patches, because the client does not report the surface.
TEST_F(SceneFetchTest, WhatTakesTooLongHereIsRefused) {
  Client client(endpoint, kRest, modelled(), "ball");
  SceneFetchOptions slow;
  slow.clock = [now = Nanoseconds(0), reads = 0]() mutable { return now += ++reads * 100us; };
  SceneFetch fetch(endpoint, ready, slow);
  const ScenePlace place{client.joined.accepted.session, 0};
  look(fetch, place, "a refusal", [&] { return !fetch.refusal().empty(); });
  EXPECT_NE(fetch.refusal().find("near object 0 it takes more than the 250 us"), std::string::npos);
  for (int i = 0; i < 10; ++i) fetch.look(place, now += 1h);
  EXPECT_FALSE(fetch.asking());  // The client does not fetch again.
  const FetchedScene* none = nullptr;
  EXPECT_FALSE(ready.pop(none));
  EXPECT_EQ(fetch.known(), 0u);
}

TEST_F(SceneFetchTest, FeelsTheWholeBodyFromThenOn) {
  FeelingClient client(endpoint, "ring", ready);
  SceneFetch fetch(endpoint, ready, kQuick);
  look(fetch, {client.joined.accepted.session, 0}, "the server knows of ring and bunny",
       [&] { return fetch.known() == kSolids; });
  const LiveStatus status = client.renders(fetch);
  EXPECT_EQ(status.scene.fetched->objects.size(), kSolids);
  ASSERT_NE(status.scene.fetched->body, nullptr);
  const ShellContact contact =
      status.scene.fetched->body->solids->contact({Vec3(0.03, 0, 0.02), {1, 0, 0, 0}});
  EXPECT_GT(contact.touching, 100u);
  client.stop.set();
  client.finish();
  EXPECT_GT(client.servo.statistics().local_model.whole, 0u);
}

TEST_F(SceneFetchTest, ASceneWithoutMeshesHasNothingToFetch) {
  Client client(endpoint, kRest, modelled(), "floor");
  SceneFetch fetch(endpoint, ready);
  const ScenePlace place{client.joined.accepted.session, 0};
  look(fetch, place, "a question", [&] { return fetch.asking(); });
  look(fetch, place, "its answer", [&] { return !fetch.asking(); });
  for (int i = 0; i < 10; ++i) fetch.look(place, now += 1h);
  EXPECT_FALSE(fetch.asking());
  EXPECT_EQ(fetch.known(), 0u);
}

/// Another session may belong to another server. The scenes of both servers may have equal version
/// numbers.
TEST_F(SceneFetchTest, AnotherSessionFetchesAnew) {
  SceneFetch fetch(endpoint, ready, kQuick);
  const FetchedScene *first = nullptr, *second = nullptr;
  for (const FetchedScene** got : {&first, &second}) {
    Client client(endpoint, kRest, modelled(), "ball");
    look(fetch, {client.joined.accepted.session, 0}, "surfaces", [&] { return ready.pop(*got); });
    look(fetch, {client.joined.accepted.session, 0}, "the end of all questions",
         [&] { return !fetch.asking() && fetch.known() == 1; });
  }
  EXPECT_NE(first, second);
  EXPECT_EQ(first->surfaces->version(), second->surfaces->version());
}

/// Wrong answers of a server must not reach the servo.
TEST_F(SceneFetchTest, ABadServerGivesNothing) {
  control::SurfaceEntry entry{.surface = {}, .vertices = 3, .triangles = 1};
  for (const control::Message& answer :
       {control::Message(control::SurfaceList{1, {entry}}),  // A SurfacePart does not follow.
        control::Message(control::Refused{control::RefusalCode::malformed, "no"}),
        control::Message(control::SolidList{.version = 1}),
        control::Message(control::SurfacesTaken{1})}) {
    testing::ControlPeer peer(control::encode(answer));
    SceneFetch fetch(peer.access(), ready, {.timeout = 2s});
    look(fetch, {1, 0}, "a question", [&] { return fetch.asking(); });
    test::eventually("its end", [&] {
      fetch.look({}, now);
      return !fetch.asking();
    });
    const FetchedScene* none = nullptr;
    EXPECT_FALSE(ready.pop(none));
  }
}

}  // namespace
}  // namespace feltwire::scene_fetch_test

// Hands choose their tools. The tests use SceneSessions with a simulated clock, and a complete
// server.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>
#include <fstream>
#include <map>

#include "core/mesh/tessellation.hpp"
#include "core/scene_file/load_scene.hpp"
#include "core/tool/body_tool.hpp"
#include "server/app/server.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/moving.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/reload.hpp"
#include "tests/server/sample_exchange.hpp"
#include "tests/support/allocation_counter.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::tool_choice_test {
namespace {

using namespace std::chrono_literals;
using control::JoinAccepted;
using control::RefusalCode;
using ::testing::HasSubstr;

constexpr std::uint64_t kFirst = 1 << 8, kSecond = 2 << 8, kThird = 3 << 8;
constexpr double kBall = 0.004, kTick = kDefaultTick;
const Material kGrippy{
    .stiffness = 1000, .damping = 1.0, .static_friction = 0.9, .dynamic_friction = 0.7};

HandTool tip(const char* name = "tip") { return {.radius = 0.0, .body = nullptr, .name = name}; }
HandTool ball() { return {.radius = kBall, .body = nullptr, .name = "ball"}; }
HandTool brick() {
  return {.radius = 0.0,
          .body = std::make_shared<const BodyTool>(
              point_shell(tessellate(Box{Vec3(0.03, 0.02, 0.01)}, 3), 300), ToolCoupling{}, 2.4e-3),
          .name = "brick"};
}

/// Returns a floor at z = 0 for hands with these tools.
Scene floor_for(std::vector<HandTool> tools) {
  Scene scene("room", {test::object("floor", Plane{}, {.stiffness = 1000.0})});
  if (!tools.empty()) scene.set_tools(std::move(tools));
  return scene;
}

/// Returns a weightless ball of 3 cm for all three tools.
Scene ball_for_all() {
  Scene scene = test::moving({test::object("ball", Sphere{0.03}, kGrippy)}, {0},
                             {test::body("ball", 0.2)}, test::kWeightless);
  scene.set_tools({tip(), ball(), brick()});
  return scene;
}

struct Bench : test::SampleExchange {
  using SampleExchange::SampleExchange;

  control::Message join(std::uint64_t id, const std::string& tool = {},
                        Role role = Role::operator_) {
    control::JoinRequest request = test::join_request(SessionParameters{});
    request.device.rotation_sensed = request.device.rotation_actuated = 3;
    request.device.rotational_damping = 1e-3;
    request.device.max_torque = 0.5;
    request.parameters.local_model = true;
    request.tool = tool;
    request.role = role;
    return sessions.answer(request, id, test::keys(id), now);
  }
  JoinAccepted joined(std::uint64_t id, const std::string& tool = {}) {
    return std::get<JoinAccepted>(join(id, tool));
  }
  Reply hand(std::uint64_t id, const Pose& pose) {
    Sample sample;
    sample.pose = pose;
    Reply reply;
    EXPECT_EQ(decode(send(id, sample, true), reply), DropReason::none);
    return reply;
  }
  Reply hand(std::uint64_t id, const Vec3& place) {
    return hand(id, Pose{place, Quaternion::Identity()});
  }
  /// Returns the force on a hand 1 mm above the floor.
  double above(std::uint64_t id) { return hand(id, Vec3(0, 0, 0.001)).command.elastic.z(); }
};

TEST(ToolChoice, EachHandHoldsWhatItAsksFor) {
  const Scene scene = floor_for({ball(), tip(), brick()});
  Bench bench(scene);
  const JoinAccepted first = bench.joined(kFirst), second = bench.joined(kSecond, "tip"),
                     third = bench.joined(kThird, "brick");
  EXPECT_EQ(first.tool, "ball");
  EXPECT_EQ(second.tool, "tip");
  EXPECT_EQ(third.tool, "brick");
  EXPECT_FALSE(first.rotation);
  EXPECT_FALSE(second.rotation);
  EXPECT_TRUE(third.rotation);
  EXPECT_NEAR(bench.above(kFirst), 3.0, 1e-9);
  EXPECT_EQ(bench.above(kSecond), 0.0);
  for (int n = 0; n < 20; ++n) bench.above(kThird);
  EXPECT_GT(bench.above(kThird), 1.0);
  // A point's local model is the floor. A ball's model is the plane where the ball's centre stops.
  const LocalModel of_ball = bench.hand(kFirst, Vec3(0, 0, 0.01)).model;
  const LocalModel of_tip = bench.hand(kSecond, Vec3(0, 0, 0.01)).model;
  ASSERT_EQ(of_ball.count, 1);
  ASSERT_EQ(of_tip.count, 1);
  EXPECT_NEAR(of_ball.patches[0].point.z() - of_tip.patches[0].point.z(), kBall, 1e-9);
}

TEST(ToolChoice, WhatIsNotThereIsRefusedWithWhatThereIs) {
  const Scene several = floor_for({ball(), tip()}), one = floor_for({});
  Bench bench(several), alone(one);
  for (const Role role : {Role::operator_, Role::observer}) {
    const auto refused = std::get<control::Refused>(bench.join(kFirst, "key", role));
    EXPECT_EQ(refused.code, RefusalCode::unknown_tool);
    EXPECT_EQ(refused.reason,
              "there is no tool 'key' in scene 'room'; the existing ones are: ball, tip");
  }
  const auto refused = std::get<control::Refused>(alone.join(kFirst, "tip"));
  EXPECT_EQ(refused.code, RefusalCode::unknown_tool);
  EXPECT_THAT(refused.reason, HasSubstr("all hands hold the same there: ask for none"));
  EXPECT_EQ(bench.sessions.size() + alone.sessions.size(), 0u);
  EXPECT_EQ(alone.joined(kFirst).tool, "");
  EXPECT_TRUE(std::holds_alternative<JoinAccepted>(bench.join(kFirst, "tip", Role::observer)));
}

// Newton's third law, up to rounding: the ball gets the negative of the forces on three hands with
// three tools.
TEST(ToolChoice, ManyToolsMoveOneBody) {
  const Scene scene = ball_for_all();
  Bench bench(scene);
  bench.joined(kFirst);
  bench.joined(kSecond, "ball");
  bench.joined(kThird, "brick");
  const World& world = *bench.sessions.world();
  Vec3 told = Vec3::Zero();
  std::map<std::uint64_t, double> pushed;
  for (int n = 0; n < 1000; ++n) {
    const double t = kTick * n;
    const Vec3 centre = world.objects()[0].pose.position;
    for (const auto& [id, place] :
         {std::pair(kFirst, Vec3(-0.0293 + 4e-4 * std::sin(30 * t), 2e-3 * std::sin(9 * t), 0)),
          std::pair(kSecond, Vec3(0.0331, 1e-3 * std::sin(20 * t), 2e-3)),
          std::pair(kThird, Vec3(0, 1e-3 * std::sin(13 * t), 0.038))}) {
      const Vec3 force = bench.hand(id, centre + place).command.force();
      told += kTick * force;
      pushed[id] += kTick * force.norm();
    }
    if (n == 0) bench.allocated = 0;
    const std::size_t before = test::allocations();
    bench.sessions.tick(bench.now += 1ms);
    bench.allocated += test::allocations() - before;
  }
  for (const auto& [id, impulse] : pushed) EXPECT_GT(impulse, 0.1) << id;
  EXPECT_NEAR((world.momentum() + told).norm(), 0.0, 1e-12);
#ifndef FELTWIRE_SANITIZED
  EXPECT_EQ(bench.allocated, 0u);
#endif
}

TEST(ToolChoice, AReloadKeepsTheHandsWhoseToolIsThere) {
  const Scene before = floor_for({ball(), tip(), brick()}),
              after = floor_for({tip("pin"), brick(), ball()});
  Bench bench(before);
  bench.joined(kFirst);  // This hand names no tool and gets the first.
  bench.joined(kSecond, "tip");
  bench.joined(kThird, "ball");
  for (const std::uint64_t id : {kFirst, kSecond, kThird}) bench.above(id);
  const auto goodbyes = bench.sessions.enter(after, bench.now);
  ASSERT_EQ(goodbyes.size(), 1u);
  GoodbyeReason reason = GoodbyeReason::leaving;
  EXPECT_EQ(decode(test::opened(goodbyes[0].datagram, test::Way::down), reason), DropReason::none);
  EXPECT_EQ(reason, GoodbyeReason::evicted);
  EXPECT_EQ(bench.sessions.find(kSecond), nullptr);
  EXPECT_EQ(bench.sessions.counters().evicted, 1u);
  EXPECT_THAT(bench.sessions.ended(),
              ::testing::ElementsAre(EndedSession{kSecond, SessionEnd::tool_gone}));
  EXPECT_EQ(bench.above(kFirst), 0.0);
  EXPECT_NEAR(bench.above(kThird), 3.0, 1e-9);
  EXPECT_EQ(std::get<control::Refused>(bench.join(kSecond, "tip")).code, RefusalCode::unknown_tool);
}

// A reload leads to other kinds of tools in a world with moving bodies, and back.
TEST(ToolChoice, AReloadPutsHandsIntoAWorldWithTheirTools) {
  const Scene still = floor_for({brick(), ball(), tip()}), moving = ball_for_all();
  Bench bench(still);
  bench.joined(kFirst);
  bench.joined(kSecond, "ball");
  bench.above(kFirst);
  bench.above(kSecond);
  EXPECT_TRUE(bench.sessions.enter(moving, bench.now).empty());
  // The tool is now a point.
  EXPECT_EQ(bench.hand(kFirst, Vec3(-0.0305, 0, 0)).command, Command{});
  bench.hand(kSecond, Vec3(0.0335, 0, 0));
  bench.sessions.tick(bench.now += 1ms);
  // The tool now rests.
  EXPECT_GT(bench.hand(kSecond, Vec3(0.0335, 0, 0)).command.force().x(), 0.1);
  bench.sessions.tick(bench.now += 1ms);
  EXPECT_LT(bench.sessions.world()->momentum().x(), 0.0);
  EXPECT_TRUE(bench.sessions.enter(still, bench.now).empty());
  EXPECT_NEAR(bench.above(kSecond), 3.0, 1e-9);
}

/// Returns a scene file with these tools.
std::string json(const std::string& tools) {
  return R"({"name": "room", "materials": [{"name": "m", "stiffness": 1000}],
"objects": [{"name": "floor", "plane": {}, "material": "m"}], "tools": [)" +
         tools + "]}";
}

// A reload of a complete server removes a tool. The client must get a goodbye, and later a refusal
// that names the tool.
TEST(ToolChoice, AServersReloadTakesAToolAway) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  const std::string kBallTool = R"({"name": "ball", "sphere": {"radius": 0.004}})";
  std::ofstream(file) << json(kBallTool + R"(, {"name": "key"})");
  ServerConfig config = test::any_port();
  config.scenes = {file};
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(file));
  Server server(config, std::move(scenes), test::security());
  test::ControlClient client(server.control_port());
  control::JoinRequest request = test::join_request(SessionParameters{});
  request.tool = "key";
  const auto joined = client.join(request);
  EXPECT_EQ(joined.accepted.tool, "key");
  test::RawSocket socket(SOCK_DGRAM, joined.udp_port);
  test::SealedEncoder encoder(test::Way::up, joined.keys);
  socket.send(encoder.samples(joined.accepted.session, 1, test::hand_batch(1)));
  Reply reply;
  EXPECT_EQ(decode(test::opened(socket.receive(), test::Way::down, joined.keys), reply),
            DropReason::none);
  std::ofstream(file) << json(kBallTool);
  EXPECT_THAT(test::reload(server), ::testing::IsEmpty());
  GoodbyeReason reason = GoodbyeReason::leaving;
  EXPECT_EQ(decode(test::opened(socket.receive(), test::Way::down, joined.keys), reason),
            DropReason::none);
  EXPECT_EQ(reason, GoodbyeReason::evicted);
  const auto refused = client.ask<control::Refused>(request);
  EXPECT_EQ(refused.code, RefusalCode::unknown_tool);
  EXPECT_EQ(refused.reason, "there is no tool 'key' in scene 'room'; the existing ones are: ball");
  test::eventually("the end of the session in the list", [&] {
    return client.ask<control::SessionList>(control::ListSessions{}).sessions.empty();
  });
}

}  // namespace
}  // namespace feltwire::tool_choice_test

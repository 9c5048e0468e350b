// A scene reloads under hands, and for an observer without a force.

#include "tests/server/reload.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>
#include <signal.h>

#include <fstream>

#include "core/scene_file/load_scene.hpp"
#include "server/app/server.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/moving.hpp"
#include "tests/protocol/sealed.hpp"
#include "tests/server/make.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/resting_hand.hpp"
#include "tests/support/program.hpp"

namespace feltwire::reload_test {
namespace {

using namespace std::chrono_literals;
using test::ControlClient;
using ::testing::HasSubstr;
using ::testing::StartsWith;

constexpr std::uint64_t kId = 0x1234567800;

/// Returns a floor at z = 0. The hand is 1 mm below.
Scene floor_of(double stiffness) {
  return Scene("room", {test::object("floor", Plane{}, {.stiffness = stiffness})});
}

struct Hand {
  explicit Hand(SceneSessions& in, Role role = Role::operator_) : sessions(in) {
    control::JoinRequest request = test::join_request(SessionParameters{});
    request.parameters.local_model = true;
    request.role = role;
    const auto answer = sessions.answer(request, kId, test::keys(kId), now);
    EXPECT_TRUE(std::holds_alternative<control::JoinAccepted>(answer));
  }
  Reply at(const Vec3& place) {
    SampleBatch batch = test::hand_batch(++index);
    batch.samples[0].pose.position = place;
    now += 1ms;
    DatagramBuffer out;
    const Bytes answer = sessions.receive(encoder.samples(kId, index, batch), {}, now, out);
    Reply reply;
    EXPECT_EQ(decode(test::opened(answer, test::Way::down), reply), DropReason::none);
    return reply;
  }

  SceneSessions& sessions;
  test::SealedEncoder encoder{test::Way::up};
  Nanoseconds now{0};
  std::uint64_t index = 0;
};

TEST(Reload, SessionsGoOnInTheOtherScene) {
  const Scene soft = floor_of(500), hard = floor_of(2000);
  SceneSessions sessions(soft, 2s, 2);
  Hand hand(sessions);
  const Vec3 below(0, 0, -0.001);
  EXPECT_NEAR(hand.at(below).command.elastic.z(), 0.5, 1e-12);
  sessions.enter(hard, hand.now);
  const Reply reply = hand.at(below);
  EXPECT_NEAR(reply.command.elastic.z(), 2.0, 1e-12);
  EXPECT_EQ(reply.model.patches[0].material.stiffness, 2000.0);
  EXPECT_EQ(sessions.counters().sessions_served, 1u);
  EXPECT_EQ(sessions.counters().samples.samples, 2u);
}

TEST(Reload, WhatMovesBeginsAnewAndIsCountedOn) {
  const Scene still = floor_of(500);
  const Scene moving = test::moving({test::object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                                    {test::body("ball", 0.2)}, test::kWeightless);
  SceneSessions sessions(still, 2s, 2);
  Hand hand(sessions);
  hand.at({-0.029, 0, 0.1});
  EXPECT_EQ(sessions.world(), nullptr);
  sessions.enter(moving, hand.now);
  ASSERT_NE(sessions.world(), nullptr);
  for (int n = 0; n < 10; ++n) hand.at({-0.029, 0, 0});
  EXPECT_EQ(sessions.world()->counters().steps, 10u);
  EXPECT_GT(sessions.world()->momentum().x(), 0.0);
  sessions.enter(moving, hand.now);
  EXPECT_EQ(sessions.world()->momentum(), Vec3::Zero());
  hand.at({-0.029, 0, 0});
  EXPECT_EQ(sessions.counters().world.steps, 11u);
  sessions.enter(still, hand.now);
  EXPECT_EQ(sessions.world(), nullptr);
  hand.at({0, 0, -0.001});
  EXPECT_EQ(sessions.counters().world.steps, 11u);
}

TEST(Observer, FeelsNothingAndMovesNothing) {
  const Scene scene = test::moving({test::object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                                   {test::body("ball", 0.2)}, test::kWeightless);
  for (const Role role : {Role::observer, Role::operator_}) {
    SceneSessions sessions(scene, 2s, 2);
    Hand hand(sessions, role);
    Reply reply;
    for (int n = 0; n < 10; ++n) reply = hand.at({-0.029, 0, 0});
    const bool acts = role == Role::operator_;
    EXPECT_EQ(reply.command != Command{}, acts);
    EXPECT_EQ(reply.modelled, acts);
    EXPECT_EQ(sessions.world()->momentum() != Vec3::Zero(), acts);
  }
}

std::string json(double stiffness, const std::string& name = "room") {
  return R"({"name": ")" + name + R"(", "materials": [{"name": "m", "stiffness": )" +
         std::to_string(stiffness) + R"(}],
"objects": [{"name": "floor", "plane": {}, "material": "m"}]})";
}

TEST(Reload, AnAdminAsksForItAndABadFileChangesNothing) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  std::ofstream(file) << json(500);
  const IssuedToken anna = issue_token("anna", "*", Role::operator_, std::nullopt);
  ServerConfig config = test::any_port();
  config.scenes = {file};
  std::vector<Scene> scenes;
  scenes.push_back(load_scene(file));
  Server server(config, std::move(scenes), test::security({anna.token}));
  ControlClient admin(server.control_port());
  test::RestingHand hand(admin);
  const auto refusal = [&](ControlClient& by, const std::string& scene = "room") {
    return by.ask<control::Refused>(control::ReloadScene{scene});
  };
  EXPECT_NEAR(hand.force(), 0.5, 1e-9);

  std::ofstream(file) << json(1500);
  EXPECT_EQ(admin.ask<control::SceneReloaded>(control::ReloadScene{"room"}).scene, "room");
  EXPECT_NEAR(hand.force(), 1.5, 1e-9);

  ControlClient no_admin(server.control_port(), AF_INET, anna.text);
  EXPECT_EQ(refusal(no_admin).code, control::RefusalCode::forbidden);
  EXPECT_EQ(refusal(admin, "attic").code, control::RefusalCode::unknown_scene);
  std::ofstream(file) << json(-3);
  EXPECT_EQ(refusal(admin).code, control::RefusalCode::bad_scene);
  EXPECT_THAT(refusal(admin).reason, HasSubstr("room.json:1: materials[0].stiffness"));
  std::ofstream(file) << json(700, "attic");
  EXPECT_THAT(refusal(admin).reason, HasSubstr("keep the name"));
  EXPECT_THAT(test::reload(server), ::testing::ElementsAre(HasSubstr("keep the name")));
  EXPECT_NEAR(hand.force(), 1.5, 1e-9);
  std::ofstream(file) << json(700);
  EXPECT_THAT(test::reload(server), ::testing::IsEmpty());
  EXPECT_NEAR(hand.force(), 0.7, 1e-9);
}

TEST(Reload, TheProgramDoesItAtSighup) {
  const testing::TemporaryFolder folder;
  const std::string file = folder / "room.json";
  std::ofstream(file) << json(500);
  test::Program program(FELTWIRE_SERVER_PROGRAM,
                        {"--scene", file, "--port", "0", "--state", folder / "state"});
  EXPECT_THAT(program.line(), StartsWith("fingerprint: "));
  EXPECT_THAT(program.line(), StartsWith("listening: "));
  std::ofstream(file) << "{";
  program.signal(SIGHUP);
  EXPECT_THAT(program.error_until("stays as it was"), HasSubstr("room.json:1"));
  std::filesystem::permissions(folder / "state", std::filesystem::perms::all);
  program.signal(SIGHUP);
  EXPECT_THAT(program.error_until("the certificate stays as it was"), HasSubstr("chmod"));
  program.signal(SIGTERM);
  const test::Outcome outcome = program.finish();
  EXPECT_EQ(outcome.status, 0);
}

}  // namespace
}  // namespace feltwire::reload_test

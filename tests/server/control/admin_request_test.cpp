// Tests an admin's requests to a running server over TLS: changes, lists, counters and refusals.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <filesystem>

#include "server/app/server.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/server/resting_hand.hpp"

namespace feltwire::admin_request_test {
namespace {

using control::RefusalCode;
using control::Refused;
using test::ControlClient;
using ::testing::HasSubstr;

const control::SetMaterial kSofter{"room", {.object = "floor", .stiffness = 500.0}};

class AdminRequest : public ::testing::Test {
 protected:
  AdminRequest()
      : server_(test::any_port(), scenes(),
                test::security({anna_.token, eye_.token, other_.token, robot_.token})) {}
  static std::vector<Scene> scenes() {
    std::vector<Scene> all;
    all.push_back(test::room());
    return all;
  }

  IssuedToken anna_ = issue_token("anna", "*", Role::operator_, std::nullopt),
              eye_ = issue_token("eye", "*", Role::observer, std::nullopt),
              other_ = issue_token("other admin", "theatre", Role::admin, std::nullopt),
              robot_ = issue_token("robot", "room", Role::follower, std::nullopt);
  Server server_;
  ControlClient admin_{server_.control_port()};
};

TEST_F(AdminRequest, AChangeOfAMaterialIsFelt) {
  test::RestingHand hand(admin_);
  EXPECT_NEAR(hand.force(), 2.0, 1e-9);
  const auto changed = admin_.ask<control::SceneChanged>(kSofter);
  EXPECT_EQ(changed.scene, "room");
  EXPECT_EQ(changed.what, "object 'floor': stiffness 2000 -> 500 [N/m]");
  EXPECT_NEAR(hand.force(), 0.5, 1e-9);

  const auto list =
      admin_.ask<control::SessionDescriptions>(control::DescribeSessions{"room", 0}).sessions;
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].session, hand.session());
  EXPECT_EQ(list[0].number, 1u);
  EXPECT_EQ(list[0].samples, 2u);
  EXPECT_EQ(list[0].balance, std::nullopt);

  const auto counter = [&](const std::string& scene, const std::string& name) {
    for (const control::Counter& c :
         admin_.ask<control::Counters>(control::GetCounters{scene}).counters)
      if (c.name == name) return c.value;
    ADD_FAILURE() << name;
    return std::uint64_t{0};
  };
  EXPECT_EQ(counter("room", "samples"), 2u);
  EXPECT_EQ(counter("room", "sessions_served"), 1u);
  EXPECT_EQ(counter("room", "unsent"), 0u);
  EXPECT_EQ(counter("room", "dropped.sealed"), 0u);
  EXPECT_EQ(counter("", "connections"), 1u);
  EXPECT_EQ(counter("", "unauthenticated"), 0u);
}

TEST_F(AdminRequest, NobodyElseMay) {
  for (const IssuedToken* token : {&anna_, &eye_}) {
    ControlClient client(server_.control_port(), AF_INET, token->text);
    for (const control::Message& request :
         {control::Message(kSofter), control::Message(control::SetGravity{"room", Vec3::Zero()}),
          control::Message(control::GetCounters{"room"}),
          control::Message(control::WriteFlightRecord{"room"}),
          control::Message(control::RecordScene{"room"}),
          control::Message(control::RecordScene{"room", control::RecordingAction::start}),
          control::Message(control::GetCounters{})}) {
      const auto refused = client.ask<Refused>(request);
      EXPECT_EQ(refused.code, RefusalCode::forbidden) << request.index();
      EXPECT_THAT(refused.reason, HasSubstr("this is for admins"));
    }
  }
  // The server must hide this scene from an admin of another scene.
  ControlClient client(server_.control_port(), AF_INET, other_.text);
  for (const control::Message& request :
       {control::Message(kSofter), control::Message(control::DescribeSessions{"room", 0}),
        control::Message(control::DescribeScene{"room", 0}),
        control::Message(control::WriteFlightRecord{"room"}),
        control::Message(control::RecordScene{"room", control::RecordingAction::start}),
        control::Message(control::GetCounters{"room"})})
    EXPECT_EQ(client.ask<Refused>(request).code, RefusalCode::unknown_scene);
}

TEST_F(AdminRequest, AnObserverIsToldWhoIsThereAndWhatIsInForce) {
  test::RestingHand hand(admin_);
  admin_.ask<control::SceneChanged>(kSofter);
  ControlClient eye(server_.control_port(), AF_INET, eye_.text);
  const auto list =
      eye.ask<control::SessionDescriptions>(control::DescribeSessions{"room", 0}).sessions;
  ASSERT_EQ(list.size(), 1u);
  EXPECT_EQ(list[0].session, hand.session());
  EXPECT_GE(list[0].seconds.value(), 0.0);
  EXPECT_FALSE(list[0].times.heard());
  const auto scene = eye.ask<control::SceneDescription>(control::DescribeScene{"room", 0});
  EXPECT_EQ(scene.version, 1u);
  EXPECT_EQ(scene.changes, 1u);
  EXPECT_EQ(scene.gravity, std::nullopt);
  EXPECT_EQ(scene.objects, 2u);
  ASSERT_TRUE(scene.times.answers && scene.times.world_late);
  std::uint64_t answers = 0;
  for (const std::uint64_t count : scene.times.answers->counts()) answers += count;
  EXPECT_EQ(answers, list[0].samples);
  EXPECT_EQ(scene.times.world_late, TimeCounts());  // Nothing moves in this scene.
  ASSERT_EQ(scene.materials.size(), 2u);
  EXPECT_EQ(scene.materials[0].stiffness, 500.0);
  EXPECT_EQ(scene.materials[1].stiffness, 1500.0);
  EXPECT_EQ(eye.ask<control::SceneDescription>(control::DescribeScene{"room", 1}).materials.size(),
            1u);
  EXPECT_TRUE(
      eye.ask<control::SceneDescription>(control::DescribeScene{"room", 9}).materials.empty());
  EXPECT_EQ(eye.ask<Refused>(control::DescribeScene{"attic", 0}).code, RefusalCode::unknown_scene);
}

TEST_F(AdminRequest, ARobotIsToldOfNobody) {
  ControlClient robot(server_.control_port(), AF_INET, robot_.text);
  for (const control::Message& request : {control::Message(control::DescribeSessions{"room", 0}),
                                          control::Message(control::DescribeScene{"room", 0})})
    EXPECT_EQ(robot.ask<Refused>(request).code, RefusalCode::forbidden);
}

/// A scene's thread answers an observer's requests, so the server must limit their rate.
TEST_F(AdminRequest, AnObserverThatAsksWithoutEndIsRefused) {
  ControlClient eye(server_.control_port(), AF_INET, eye_.text);
  const auto is_refused = [&] {
    eye.send(control::DescribeSessions{"room", 0});
    const auto answer = eye.receive();
    return answer && std::holds_alternative<Refused>(*answer);
  };
  int asked = 0;
  while (asked < 10'000 && !is_refused()) ++asked;
  EXPECT_GE(asked, 60);
  EXPECT_LT(asked, 10'000);
}

TEST_F(AdminRequest, WhatCannotBeIsRefusedInWords) {
  const auto refused =
      admin_.ask<Refused>(control::SetMaterial{"room", {.object = "floor", .stiffness = -1.0}});
  EXPECT_EQ(refused.code, RefusalCode::bad_parameters);
  EXPECT_THAT(refused.reason, HasSubstr("object 'floor': stiffness: must be above zero [N/m]"));
  EXPECT_THAT(admin_.ask<Refused>(control::SetGravity{"room", Vec3::Zero()}).reason,
              HasSubstr("nothing moves"));
  EXPECT_EQ(admin_.ask<Refused>(control::GetCounters{"attic"}).code, RefusalCode::unknown_scene);
}

TEST_F(AdminRequest, AFlightRecordIsWrittenAndNamed) {
  const auto none = admin_.ask<Refused>(control::WriteFlightRecord{"room"});
  EXPECT_EQ(none.code, RefusalCode::not_supported);
  EXPECT_THAT(none.reason, HasSubstr("start it with --flight-recorder DIR"));

  const testing::TemporaryFolder folder;
  ServerConfig config = test::any_port();
  config.recording.flight_folder = folder / "flights";
  Server server(config, scenes(), test::security());
  ControlClient admin(server.control_port());
  const auto written = admin.ask<control::FlightRecordWritten>(control::WriteFlightRecord{"room"});
  EXPECT_EQ(written.scene, "room");
  EXPECT_TRUE(std::filesystem::exists(written.file)) << written.file;
  std::filesystem::remove_all(config.recording.flight_folder);
  const auto failed = admin.ask<Refused>(control::WriteFlightRecord{"room"});
  EXPECT_EQ(failed.code, RefusalCode::failed);
  EXPECT_THAT(failed.reason, HasSubstr("the server's log says why"));
}

TEST_F(AdminRequest, ARecordingIsStartedByOneAdminAndStoppedByAnother) {
  using control::RecordingAction;
  using control::RecordScene;
  const auto none = admin_.ask<Refused>(RecordScene{"room", RecordingAction::start});
  EXPECT_EQ(none.code, RefusalCode::not_supported);
  EXPECT_THAT(none.reason, HasSubstr("start it with --recordings DIR"));

  const testing::TemporaryFolder folder;
  ServerConfig config = test::any_port();
  config.recording.folder = folder / "recordings";
  Server server(config, scenes(), test::security());
  ControlClient first(server.control_port()), second(server.control_port());
  const auto begun =
      first.ask<control::SceneRecordings>(RecordScene{"room", RecordingAction::start});
  EXPECT_EQ(begun.folder, config.recording.folder.string());
  EXPECT_TRUE(std::filesystem::exists(config.recording.folder / begun.running));
  EXPECT_EQ(second.ask<control::SceneRecordings>(RecordScene{"room"}).running, begun.running);
  EXPECT_THAT(second.ask<Refused>(RecordScene{"room", RecordingAction::start}).reason,
              HasSubstr("runs already"));
  const auto ended =
      second.ask<control::SceneRecordings>(RecordScene{"room", RecordingAction::stop});
  EXPECT_EQ(ended.running, "");
  EXPECT_EQ(ended.ended, control::RecordingEnd::asked);
  ASSERT_EQ(ended.kept.size(), 1u);
  EXPECT_EQ(ended.kept[0].name, begun.running);
  EXPECT_THAT(first.ask<Refused>(RecordScene{"room", RecordingAction::stop}).reason,
              HasSubstr("no recording of the scene runs"));
}

/// Requests without a specific limit must finally get a refusal that allows a retry.
TEST_F(AdminRequest, NoRequestIsAnsweredWithoutEnd) {
  const auto asked_until_refused = [](ControlClient& client, const control::Message& request) {
    for (int asked = 0; asked < 20'000; ++asked) {
      client.send(request);
      const auto answer = client.receive();
      if (!answer) return -1;
      const auto* refused = std::get_if<Refused>(&*answer);
      if (refused != nullptr && refused->code == RefusalCode::too_many) return asked;
    }
    return 20'000;
  };
  ControlClient eye(server_.control_port(), AF_INET, eye_.text);
  const int scenes = asked_until_refused(eye, control::ListScenes{});
  EXPECT_GE(scenes, 60);
  EXPECT_LT(scenes, 2'000);
  const std::vector<control::Message> requests = {control::DescribeSessions{"room", 0},
                                                  control::DescribeScene{"room", 0},
                                                  control::ListScenes{},
                                                  control::ListSessions{},
                                                  control::GetCounters{},
                                                  control::GetCounters{"room"},
                                                  control::Evict{77},
                                                  control::LeaveRequest{77},
                                                  control::GetSurface{77, 1, 0, 0, 0},
                                                  control::SetGravity{"room", Vec3::Zero()},
                                                  control::TakeSurfaces{77, 1, {}},
                                                  control::Authenticate{test::admin_token().text}};
  for (const control::Message& request : requests)
    EXPECT_LT(asked_until_refused(admin_, request), 20'000) << request.index();
}

/// A client that sends requests without end must not use up the limit of another client name.
TEST_F(AdminRequest, TheLimitIsOfOneClientsName) {
  ControlClient anna(server_.control_port(), AF_INET, anna_.text);
  for (int n = 0; n < 3'000; ++n) {
    anna.send(control::LeaveRequest{77});
    if (!anna.receive()) break;
  }
  admin_.ask<control::Counters>(control::GetCounters{});
}

}  // namespace
}  // namespace feltwire::admin_request_test

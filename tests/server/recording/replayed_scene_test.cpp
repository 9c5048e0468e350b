// Tests recorded scenes with more than datagrams: a MuJoCo model of several files, an arm in the
// server's world, and changes that a server requests from a client.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <fstream>
#include <optional>

#include "core/base/file_error.hpp"
#include "server/recording/scene_replay.hpp"
#include "tests/server/recording/recorded_scene.hpp"

namespace feltwire::replayed_scene_test {
namespace {

using test::RecordedScene;
using test::repository_scene;
using ::testing::AllOf;
using ::testing::HasSubstr;

constexpr std::uint64_t kA = 0x100;

/// A MuJoCo model in three files. The hand pushes the cart of the model.
class ReplayOfMjcf : public ::testing::Test {
 protected:
  ReplayOfMjcf() {
    std::filesystem::create_directories(source / "parts");
    write("scene.json", R"({ "name": "carts", "materials": [{ "name": "soft", "stiffness": 400 }],
      "mjcf": { "file": "room.xml", "material": "soft" } })");
    write("room.xml", R"(<mujoco><asset><mesh name="wedge" file="wedge.obj"/></asset>
      <worldbody><include file="parts/cart.xml"/></worldbody></mujoco>)");
    write("parts/cart.xml", R"(<mujoco><body name="cart">
      <joint type="slide" axis="1 0 0"/><geom name="wedge" type="mesh" mesh="wedge"/></body></mujoco>)");
    write("wedge.obj",
          "v 0 0 0\nv 0.2 0 0\nv 0 0.2 0\nv 0 0 0.2\nf 1 3 2\nf 1 2 4\nf 1 4 3\nf 2 3 4\n");
  }
  void write(const std::string& file, const std::string& text) {
    std::ofstream(source / file) << text;
  }
  std::filesystem::path record() {
    recorded.emplace(source / "scene.json");
    recorded->join(kA);
    // The hand moves to a face and farther.
    for (int n = 0; n < 900; ++n) {
      recorded->exchange.now += std::chrono::milliseconds(1);
      Sample sample;
      sample.pose.position = Vec3(-0.01 + 2e-5 * n, 0.05, 0.05);
      recorded->exchange.send(kA, sample, false);
      if (n % 10 == 0) recorded->write();
    }
    moved = recorded->exchange.sessions.world()->objects()[0].pose.position.x();
    return recorded->finish();
  }
  testing::TemporaryFolder folder;
  std::filesystem::path source = std::filesystem::path(folder / "source");
  std::optional<RecordedScene> recorded;
  double moved = 0.0;
};

TEST_F(ReplayOfMjcf, IsBitEqualWithoutTheScenesFiles) {
  const std::filesystem::path file = record();
  EXPECT_GT(moved, 0.0505);  // The cart started at 0.05.
  std::filesystem::remove_all(source);
  const Replay result = replay({file});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
  EXPECT_EQ(result.replies, 900u);
  EXPECT_GT(result.ticks, 0u);
}

TEST_F(ReplayOfMjcf, SaysWhichFileIsMissing) {
  const std::filesystem::path file = record();
  std::filesystem::remove_all(source);
  test::rewrite(
      file, [](RecordedEvent&, std::string&) { return true; },
      [](const mcap::Attachment& attachment) { return attachment.name != "scene-0/wedge.obj"; });
  try {
    replay({file});
    FAIL() << "a replay without the mesh";
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(),
                AllOf(HasSubstr("scene.mcap: its scene scene-0: "), HasSubstr("wedge.obj"),
                      HasSubstr("was not kept"), HasSubstr("name the scene's file with --scene")));
  }
}

/// The replay must compute an arm of the scene's world again, including its sensor noise.
TEST(ReplayOfAnArm, IsBitEqual) {
  RecordedScene scene(repository_scene("arm/workcell.json"));
  scene.join(kA);
  SceneSessions& sessions = scene.exchange.sessions;
  double lowest = 1.0;
  for (int n = 0; n < 2500; ++n) {
    scene.exchange.now += std::chrono::milliseconds(1);
    scene.exchange.lead = Lead{.deadman = n > 20};
    Sample sample;
    sample.pose.position.z() = -1.5e-4 * n;  // down to the mat at 0.15 m/s
    scene.exchange.send(kA, sample, false);
    Picture picture;
    sessions.draw(picture, scene.exchange.now);
    lowest = std::min(lowest, picture.robots.front().pose.position.z());
    if (n % 100 == 0) sessions.check(scene.exchange.now);
    if (n % 10 == 0) scene.write();
  }
  EXPECT_LT(lowest, 0.31);  // The arm started at 0.49.
  EXPECT_EQ(scene.exchange.allocated, 0u);
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
  EXPECT_EQ(result.replies, 2500u);
}

/// tests/recording/check_export.py expects these numbers: two hands and a body. A hand sends each
/// sample twice, and sometimes a report.
TEST(RecordingForExport, TwoHandsAndABody) {
  constexpr std::uint64_t kB = 0x200;
  RecordedScene scene(repository_scene("plane.json"));
  scene.join(kA);
  scene.join(kB);
  DatagramBuffer out;
  const Nanoseconds begin = scene.exchange.now;
  const auto sample = [&](std::uint64_t n) {
    Sample made;
    made.index = n;
    made.client_time = begin + n * std::chrono::milliseconds(1);
    made.pose.position = Vec3(1e-4 * static_cast<double>(n), 0.02, -1e-6 * static_cast<double>(n));
    made.held.elastic = Vec3(0.0, 0.0, 0.5);
    made.held.frictional = Vec3(0.25, 0.0, 0.0);
    return made;
  };
  for (std::uint64_t n = 1; n <= 1000; ++n) {
    scene.exchange.now += std::chrono::milliseconds(1);
    scene.exchange.send(kA, sample(n), false);
    if (n % 2 == 0) {
      SampleBatch batch;
      batch.count = 2;
      batch.previous = n - 2;
      batch.samples[0] = sample(n);
      batch.samples[1] = sample(n - 1);
      if (n % 200 == 0)
        batch.report = HandReport{.reasons = bit(HandReason::late) | bit(HandReason::account),
                                  .has_account = n > 200,
                                  .balance = 1e-6 * static_cast<double>(n),
                                  .round_trip = 0.002,
                                  .late_ticks = static_cast<std::uint32_t>(n / 200)};
      scene.exchange.sessions.receive(scene.exchange.encoder.samples(kB, n, batch),
                                      scene.exchange.peer, scene.exchange.now, out);
    }
    if (n % 100 != 0) continue;
    scene.write();
    Picture picture;
    picture.time = scene.exchange.now;
    scene.exchange.sessions.draw(picture, scene.exchange.now);
    PictureBody body;
    body.object = 3;
    body.pose = {Vec3(0.0, 0.0, 1e-3 * static_cast<double>(n)), Quaternion(0.6, 0.8, 0.0, 0.0)};
    picture.bodies.push_back(body);
    scene.recording->see(picture);
  }
  const Replay result = replay({scene.finish()});
  EXPECT_TRUE(result.bit_equal()) << (result.difference ? result.difference->what : "");
  EXPECT_EQ(result.replies, 1500u);
}

/// An admin requests another bounding method and another link, and the client answers.
TEST(ReplayOfClientChanges, IsBitEqual) {
  RecordedScene scene(repository_scene("room.json"));
  SessionParameters parameters = test::server_bounds();
  parameters.side = BoundingSide::client;
  parameters.mode = "contact_frame";
  control::JoinRequest request = test::join_request(parameters);
  request.takes = {.laws = LawsTaken::any, .link = true};
  scene.join(kA, request);
  scene.run(100);
  SceneSessions& sessions = scene.exchange.sessions;
  const auto asked = [&] {
    Reply reply;
    Sample sample;
    sample.pose.position = scene.exchange.scene.start().position;
    EXPECT_EQ(decode(Bytes(scene.exchange.send(kA, sample, false)), reply), DropReason::none);
    return reply.change;
  };
  EXPECT_FALSE(asked());
  SessionParameters wanted = parameters;
  wanted.mode = "shaped";
  const control::Message set =
      sessions.answer(control::SetParameters{kA, wanted}, 0, {}, scene.exchange.now);
  ASSERT_TRUE(std::holds_alternative<control::ParametersSet>(set));
  // The old parameters stay until the client accepts the change.
  EXPECT_EQ(std::get<control::ParametersSet>(set).parameters, parameters);
  ASSERT_TRUE(asked());
  EXPECT_EQ(asked()->number, 1);
  EXPECT_EQ(asked()->law->mode.view(), "shaped");
  // Another change arrives while the first waits. The server must send both.
  ASSERT_TRUE(std::holds_alternative<Changed>(
      sessions.change(LinkChange{kA, {.delay = 0.025, .loss = 0.5}}, scene.exchange.now)));
  EXPECT_EQ(asked()->number, 2);
  EXPECT_EQ(asked()->law->mode.view(), "shaped");
  EXPECT_EQ(asked()->link->loss, 0.5);
  scene.exchange.report = HandReport{.change = 1};  // This is the report for the first change.
  EXPECT_TRUE(asked());
  EXPECT_EQ(sessions.find(kA)->parameters().mode, "contact_frame");
  scene.exchange.report = HandReport{.change = 2};
  scene.exchange.allocated = 0;
  EXPECT_FALSE(asked());
  EXPECT_EQ(scene.exchange.allocated, 0u);
  EXPECT_EQ(sessions.find(kA)->parameters().mode, "shaped");
  EXPECT_EQ(sessions.answers().size(), 1u);
  EXPECT_FALSE(sessions.has_answers());
  // A refused change must have no effect.
  sessions.answer(control::SetParameters{kA, parameters}, 0, {}, scene.exchange.now);
  EXPECT_EQ(asked()->number, 3);
  scene.exchange.report = HandReport{.change = 3, .change_refused = true};
  EXPECT_FALSE(asked());
  EXPECT_EQ(sessions.find(kA)->parameters().mode, "shaped");
  const auto listed = sessions.describe_after(0, scene.exchange.now).sessions.at(0);
  EXPECT_EQ(listed.changes.answer, ChangeAnswer::refused);
  EXPECT_THAT(listed.changes.asked, HasSubstr("mode shaped -> contact_frame"));
  // The answer about a bounding method is lost. Then a change is refused. The client may have
  // either method. The server must therefore request a return to the session's method.
  EXPECT_EQ(sessions.answers().size(), 1u);
  sessions.answer(control::SetParameters{kA, parameters}, 0, {}, scene.exchange.now);
  EXPECT_EQ(asked()->number, 4);
  EXPECT_TRUE(std::holds_alternative<Changed>(
      sessions.change(LinkChange{kA, {.delay = 0.05}}, scene.exchange.now)));
  scene.exchange.report = HandReport{.change = 5, .change_refused = true};
  scene.exchange.allocated = 0;
  const auto back = asked();
  EXPECT_EQ(scene.exchange.allocated, 0u);
  ASSERT_TRUE(back);
  EXPECT_EQ(back->number, 6);
  EXPECT_EQ(back->law->mode.view(), "shaped");
  EXPECT_FALSE(back->link);
  EXPECT_THAT(sessions.answers().at(0), HasSubstr("asked to return to the law of its session"));
  scene.exchange.report = HandReport{.change = 6};
  EXPECT_FALSE(asked());
  EXPECT_EQ(sessions.find(kA)->parameters().mode, "shaped");
  EXPECT_THAT(sessions.answers().at(0), HasSubstr("has taken the return to the law"));
  scene.run(100);
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
}

TEST(ReplayOfClientChanges, WhoTakesNoneIsNeverAsked) {
  RecordedScene scene(repository_scene("room.json"));
  SessionParameters parameters = test::server_bounds();
  parameters.side = BoundingSide::client;
  parameters.mode = "contact_frame";
  scene.join(kA, test::join_request(parameters));
  SceneSessions& sessions = scene.exchange.sessions;
  parameters.mode = "energy_tank";
  const auto no =
      sessions.answer(control::SetParameters{kA, parameters}, 0, {}, scene.exchange.now);
  ASSERT_TRUE(std::holds_alternative<control::Refused>(no));
  EXPECT_THAT(std::get<control::Refused>(no).reason, HasSubstr("takes no other law"));
  const ChangeOutcome link = sessions.change(LinkChange{kA, {}}, scene.exchange.now);
  EXPECT_THAT(std::get<control::Refused>(link).reason, HasSubstr("--link"));
  const ChangeOutcome wild = sessions.change(LinkChange{kA, {.loss = 1.5}}, scene.exchange.now);
  EXPECT_THAT(std::get<control::Refused>(wild).reason, HasSubstr("link loss must be"));
}

}  // namespace
}  // namespace feltwire::replayed_scene_test

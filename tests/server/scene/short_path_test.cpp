// Tests a path for short datagrams: the contents of a session's replies, and a bitwise equal replay
// of the recording.

#include <gtest/gtest.h>

#include <algorithm>
#include <vector>

#include "server/recording/scene_replay.hpp"
#include "tests/server/recording/recorded_scene.hpp"

namespace feltwire::short_path_test {
namespace {

using namespace std::chrono_literals;
using test::RecordedScene;

constexpr std::uint64_t kHand = 0x100, kEye = 0x200;
constexpr std::size_t kDatagram = 548;  // [bytes] for an IPv4 path of 576
constexpr std::size_t kPayload = kDatagram - kOverhead;

control::JoinRequest modelled() {
  control::JoinRequest request = test::join_request();
  request.parameters.side = BoundingSide::client;
  request.parameters.local_model = true;
  return request;
}

control::JoinRequest observer() {
  control::JoinRequest request = test::join_request();
  request.role = Role::observer;
  return request;
}

/// A tool with a body touches a corner. All parts of its model are near.
const char* const kCorner = R"({
  "name": "corner", "materials": [{ "name": "m", "stiffness": 1000 }],
  "objects": [{ "name": "top", "plane": {}, "material": "m" },
              { "name": "edge", "box": { "size": [0.05, 0.2, 0.04] }, "position": [0.055, 0, 0.02],
                "material": "m" }],
  "tool": { "body": { "box": { "size": [0.06, 0.04, 0.02] }, "points": 2000 } } })";

std::filesystem::path corner(const std::filesystem::path& folder) {
  std::ofstream(folder / "corner.json") << kCorner;
  return folder / "corner.json";
}

struct ReplySizes {
  std::size_t longest = 0, replies = 0, shortened = 0, modelled = 0;
};

/// Runs the hand for some milliseconds.
ReplySizes feel(RecordedScene& scene, std::uint64_t id, int milliseconds) {
  ReplySizes seen;
  for (int n = 0; n < milliseconds; ++n) {
    scene.exchange.now += 1ms;
    Sample sample;
    const double t = 1e-3 * static_cast<double>(scene.exchange.index[id]);
    sample.pose.position = {0.01 * std::sin(9.0 * t), 0.0, 0.010 - 0.001 * std::sin(7.0 * t)};
    const auto payload = scene.exchange.send(id, sample, false);
    Reply reply;
    SceneView view;
    EXPECT_EQ(decode(payload, reply, &view), DropReason::none);
    ++seen.replies;
    seen.longest = std::max(seen.longest, scene.exchange.length);
    seen.shortened += is_shortened(payload) ? 1 : 0;
    seen.modelled += reply.modelled || reply.body_modelled ? 1 : 0;
  }
  scene.write();
  return seen;
}

class ShortPath : public ::testing::TestWithParam<bool> {
 protected:
  testing::TemporaryFolder folder;
};

TEST_P(ShortPath, RepliesFitAndAreComputedAgainToTheSameBits) {
  const bool body = GetParam();
  RecordedScene scene(body ? corner(folder / "") : test::repository_scene("room.json"));
  SceneSessions& sessions = scene.exchange.sessions;
  scene.join(kHand, modelled());
  const ReplySizes whole = feel(scene, kHand, 300);
  EXPECT_EQ(whole.shortened, 0u);
  EXPECT_EQ(whole.modelled, whole.replies);
  if (body) {
    EXPECT_GT(whole.longest, kDatagram);
  }

  // room for some parts of a body, for some surfaces at a point, or for no model
  constexpr std::size_t kOfABody = 900;
  for (const std::size_t payload : {kOfABody, kPayload, kPayload / 2 + 40}) {
    sessions.limit_replies(kHand, payload, scene.exchange.now);
    const std::size_t before = scene.exchange.allocated;
    const ReplySizes cut = feel(scene, kHand, 300);
    EXPECT_LE(cut.longest, payload + kOverhead);
    EXPECT_EQ(scene.exchange.allocated, before);
    if (body) {
      EXPECT_GT(cut.shortened, 0u);
    }
    if (payload == (body ? kOfABody : kPayload)) {
      EXPECT_GT(2 * cut.modelled, cut.replies);
    }
  }
  ASSERT_TRUE(sessions.has_short_paths());
  const auto lines = sessions.short_paths();
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_NE(lines[0].find("takes no datagrams above"), std::string::npos) << lines[0];
  EXPECT_FALSE(sessions.has_short_paths());

  // After a minute the path may have changed.
  scene.exchange.now += 1min;
  const ReplySizes again = feel(scene, kHand, 300);
  if (body) {
    EXPECT_GT(again.longest, kDatagram);
  }
  EXPECT_EQ(again.shortened, 0u);

  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
}

INSTANTIATE_TEST_SUITE_P(OfAPointAndOfABody, ShortPath, ::testing::Bool());

/// The model's valid radius must end before the omitted parts.
TEST(ShortReply, WhatIsLeftOutIsBeyondTheReach) {
  control::JoinRequest request = modelled();
  const Scene scene = load_scene(test::repository_scene("room.json"));
  Session session(request, scene);
  int cut = 0;
  for (std::uint64_t n = 1; n <= 400; ++n) {
    SampleBatch batch = test::hand_batch(n);
    batch.samples[0].pose.position += scene.start().position;
    BatchResult taken = session.take(batch, {});
    ASSERT_EQ(taken.drop, DropReason::none);
    const LocalModel whole = taken.reply.model;
    if (!session.shorten(taken.reply, 1) || !taken.reply.modelled) continue;
    const LocalModel& left = taken.reply.model;
    ++cut;
    EXPECT_LT(left.count, whole.count);
    EXPECT_LE(left.reach, whole.reach);
    for (int i = left.count; i < whole.count; ++i) {
      const SurfacePatch& gone = whole.patches[static_cast<std::size_t>(i)];
      EXPECT_LE(left.reach, (gone.point - whole.center).norm() + 1e-9);
      if (gone.touching) {
        EXPECT_EQ(left.reach, 0.0);
      }
    }
    while (session.shorten(taken.reply, 1000)) {
    }
    EXPECT_FALSE(taken.reply.modelled);
  }
  EXPECT_GT(cut, 100);
}

/// An observer must see all hands in more turns.
TEST(ShortPathOfAnObserver, SeesAllInMoreTurns) {
  RecordedScene scene(test::repository_scene("room.json"));
  SceneSessions& sessions = scene.exchange.sessions;
  scene.join(kEye, observer());
  for (std::uint64_t i = 0; i < 7; ++i) scene.join(0x1000 + (i << 8), test::join_request());
  scene.run(3);
  for (const std::size_t payload : {kMaxPayload, kPayload, std::size_t{340}}) {
    sessions.limit_replies(kEye, payload, scene.exchange.now);
    std::vector<std::uint32_t> seen;
    for (int n = 0; n < 20; ++n) {
      scene.exchange.now += 1ms;
      Sample sample;
      const auto answer = scene.exchange.send(kEye, sample, false);
      EXPECT_LE(scene.exchange.length, payload + kOverhead);
      Reply reply;
      SceneView view;
      ASSERT_EQ(decode(answer, reply, &view), DropReason::none);
      EXPECT_EQ(is_shortened(answer), payload < kMaxPayload);
      for (const SeenHand& hand : view.hands()) seen.push_back(hand.number);
    }
    std::ranges::sort(seen);
    seen.erase(std::unique(seen.begin(), seen.end()), seen.end());
    EXPECT_EQ(seen.size(), 7u) << payload;
  }
  scene.write();
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what;
}

}  // namespace
}  // namespace feltwire::short_path_test

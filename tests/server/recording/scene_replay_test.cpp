// A replay must compute a recorded scene bitwise equally, and must find changes in the file.

#include "server/recording/scene_replay.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/file_error.hpp"
#include "core/base/splitmix.hpp"
#include "tests/core/scene_file/parts_scene.hpp"
#include "tests/server/recording/recorded_scene.hpp"

namespace feltwire::replay_test {
namespace {

using test::RecordedScene;
using test::repository_scene;
using ::testing::HasSubstr;

constexpr std::uint64_t kA = 0x100, kB = 0x200, kC = 0x300;
constexpr auto kSamples = static_cast<std::uint64_t>(EventKind::samples);

control::JoinRequest observer() {
  control::JoinRequest request = test::join_request();
  request.role = Role::observer;
  return request;
}

/// Hands join, change, get a reload and leave.
void live(RecordedScene& scene, const std::filesystem::path& reloaded) {
  SceneSessions& sessions = scene.exchange.sessions;
  SessionParameters parameters = test::server_bounds();
  parameters.force_deadband = 0.1;
  scene.join(kA, test::join_request(parameters));
  scene.run(150);
  scene.join(kB);
  scene.join(kC, observer());
  scene.run(150);
  parameters.velocity_cutoff = 50.0;
  ASSERT_TRUE(std::holds_alternative<control::ParametersSet>(
      sessions.answer(control::SetParameters{kA, parameters}, 0, {}, scene.exchange.now)));
  scene.run(150);
  static std::vector<std::shared_ptr<const Scene>> changed;  // The scenes outlive the sessions.
  const auto change = [&](const LiveChange& wanted) {
    ChangeOutcome outcome = sessions.change(wanted, scene.exchange.now);
    ASSERT_TRUE(std::holds_alternative<Changed>(outcome));
    changed.push_back(std::get<Changed>(outcome).scene);
  };
  if (!scene.exchange.scene.objects().empty())
    change(MaterialChange{.object = scene.exchange.scene.objects()[0].name,
                          .stiffness = 321.0,
                          .static_friction = 0.3,
                          .dynamic_friction = 0.2});
  if (sessions.world() != nullptr) change(GravityChange{Vec3(0.5, 0.0, -3.0)});
  scene.run(150);
  static std::vector<std::unique_ptr<Scene>> entered;  // The scenes outlive the sessions.
  entered.push_back(std::make_unique<Scene>(load_scene_and_keep(reloaded)));
  sessions.enter(*entered.back(), scene.exchange.now);
  scene.run(100);
  sessions.evict(kB);
  std::erase(scene.ids, kB);
  scene.run(50);
}

class RecordedIn : public ::testing::TestWithParam<const char*> {};

TEST_P(RecordedIn, IsBitEqual) {
  RecordedScene scene(repository_scene(GetParam()));
  live(scene, repository_scene(GetParam()));
  const SceneCounters counters = scene.exchange.sessions.counters();
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
  EXPECT_EQ(result.scene, scene.exchange.scene.name());
  EXPECT_EQ(result.replies, counters.samples.replies);
  EXPECT_GT(counters.samples.withheld, 0u);
  EXPECT_EQ(result.sessions, 3u);
  EXPECT_EQ(result.recorded_by, result.replayed_by);
  EXPECT_EQ(result.ticks > 0, scene.exchange.sessions.world() != nullptr);
  EXPECT_FALSE(result.cut_at.has_value());
}

INSTANTIATE_TEST_SUITE_P(Replay, RecordedIn,
                         ::testing::Values("plane.json", "room.json", "bunny.json", "guided.json",
                                           "workshop.json"));

/// A client's models depend on the fetched surfaces.
TEST(ReplayOfWholeSurfaces, IsBitEqual) {
  RecordedScene scene(repository_scene("bunny.json"));
  control::JoinRequest request = test::join_request({});
  request.parameters.side = BoundingSide::client;
  request.parameters.local_model = true;
  scene.join(kA, request);
  scene.join(kB, request);
  scene.run(100);
  ASSERT_TRUE(std::holds_alternative<control::SurfacesTaken>(scene.exchange.sessions.answer(
      control::TakeSurfaces{kB, 1, {1}}, 0, {}, scene.exchange.now)));
  scene.run(100);
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
  EXPECT_EQ(result.replies, 400u);
}

/// A thread without time asks clients for fewer datagrams. A replay has other times.
TEST(ReplayOfAPace, IsBitEqual) {
  RecordedScene scene(repository_scene("room.json"));
  scene.join(kA);
  scene.join(kB);
  for (int n = 0; n < 600; ++n) {
    scene.run(1);
    scene.exchange.sessions.spent(std::chrono::milliseconds(2), scene.exchange.now);
  }
  EXPECT_GE(scene.exchange.sessions.counters().slowed, 2u);
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
  EXPECT_GT(result.replies, 100u);
}

/// The replies to a robot's hand depend on the robot's states.
TEST(ReplayOfARobot, IsBitEqual) {
  RecordedScene scene(repository_scene("teleoperation/seat.json"));
  control::JoinRequest robot = test::join_request(), second = test::join_request();
  robot.role = Role::follower;
  second.lead_share = 2.0;
  scene.join(kA);
  scene.join(kB, robot);
  scene.join(kC, second);
  SceneSessions& sessions = scene.exchange.sessions;
  Encoder payload;
  DatagramBuffer out;
  int engaged = 0;
  for (std::uint64_t n = 1; n <= 300; ++n) {
    scene.exchange.now += std::chrono::milliseconds(1);
    const Nanoseconds now = scene.exchange.now;
    if (n == 10) {
      ASSERT_TRUE(std::holds_alternative<Changed>(sessions.change(LeadChange{kA, 1.0}, now)));
    }
    RobotState state;
    state.index = n;
    state.pose.position = state.commanded.position = Vec3(0.1, 0.2, 1e-3 * static_cast<double>(n));
    sessions.receive(
        scene.exchange.encoder.seal({DatagramKind::follower_state, kB, n}, payload.state(state)),
        scene.exchange.peer, now, out);
    SampleBatch batch;
    batch.count = 1;
    batch.previous = n - 1;
    batch.samples[0].index = n;
    batch.samples[0].client_time = now;
    batch.lead = Lead{.deadman = n > 20};
    batch.samples[0].pose.position.x() = 1e-6 * static_cast<double>(n);
    sessions.receive(scene.exchange.encoder.samples(kA, n, batch), scene.exchange.peer, now, out);
    sessions.receive(scene.exchange.encoder.samples(kC, n, batch), scene.exchange.peer, now, out);
    engaged += sessions.link_state(0) == LinkState::engaged ? 1 : 0;
    scene.write();
  }
  EXPECT_EQ(engaged, 280);
  const Replay result = replay({scene.finish()});
  ASSERT_TRUE(result.bit_equal()) << result.difference->what << " at event "
                                  << result.difference->event;
  EXPECT_EQ(result.replies, 600u);
}

class ReplayOfParts : public test::PartsScene {};

/// The recording of a hollow body has its convex parts. Without these parts, the replay must
/// compute them.
TEST_F(ReplayOfParts, IsBitEqualWhereverThePartsComeFrom) {
  write("ring.obj", test::torus(0.05, 0.015, 24, 12));
  const auto scene_file = write_scene(
      R"({ "name": "ring", "mass": 0.1, "position": [0, 0, 0.03], "orientation": [0.9, 0.3, 0.2, 0.1] })",
      R"({ "name": "floor", "plane": {}, "material": "m" },
  { "name": "rod", "cylinder": { "radius": 0.01, "length": 0.3 }, "material": "m" }, )" +
          test::mesh_text("ring", "ring.obj", "", R"(, "body": "ring")"),
      R"("start": { "position": [0.05, 0, 0.04] }, )");
  for (const bool is_kept : {false, true}) {  // The recorded file has the parts.
    SCOPED_TRACE(is_kept);
    ASSERT_EQ(kept_in(scenes()).size(), is_kept ? 1u : 0u);
    RecordedScene scene(scene_file);
    scene.join(kA);
    scene.run(400);
    const auto file = scene.finish();
    const auto is_equal = [&] {
      const Replay result = replay({file});
      EXPECT_TRUE(result.bit_equal())
          << result.difference->what << " at event " << result.difference->event;
      EXPECT_GT(result.ticks, 300u);
    };
    is_equal();
    int parts = 0;
    test::rewrite(
        file, [](RecordedEvent&, std::string&) { return true; },
        [&](const mcap::Attachment& attachment) {
          const bool is_part = attachment.name == "scene-0/ring.obj.m.auto.64.convex";
          parts += is_part ? 1 : 0;
          return !is_part;
        });
    EXPECT_EQ(parts, 1);
    is_equal();
  }
}

class ReplayTest : public ::testing::Test {
 protected:
  RecordedScene scene{repository_scene("room.json")};
  std::filesystem::path record() {
    scene.join(kA);
    scene.join(kB);
    scene.run(300);
    return scene.finish();
  }
};

TEST_F(ReplayTest, ChangedDigestIsFoundWhereItIs) {
  const auto file = record();
  std::uint64_t changed = 0;
  test::rewrite(file, [&](RecordedEvent& event, std::string&) {
    if (changed == 0 && event.kind == kSamples && event.number > 200) {
      event.digest ^= 1;
      changed = event.number;
    }
    return true;
  });
  const Replay result = replay({file});
  ASSERT_TRUE(result.difference.has_value());
  EXPECT_FALSE(result.bit_equal());
  EXPECT_EQ(result.difference->event, changed);
  EXPECT_GT(result.difference->hand, 0u);
  EXPECT_GT(result.difference->sample, 0u);
  EXPECT_GT(result.difference->time, 0.0);
  EXPECT_THAT(result.difference->what, HasSubstr("the reply has other bytes"));
}

/// The test changes a single bit of a hand's position.
TEST_F(ReplayTest, ChangedSampleIsFound) {
  const auto file = record();
  std::uint64_t seen = 0;
  test::rewrite(file, [&](RecordedEvent& event, std::string& payload) {
    if (event.kind != kSamples || ++seen != 100) return true;
    Encoder encoder;
    SampleBatch batch;
    std::vector<std::uint64_t> aligned(payload.size() / 8 + 1);
    std::memcpy(aligned.data(), payload.data(), payload.size());
    const Bytes bytes{reinterpret_cast<const std::uint8_t*>(aligned.data()), payload.size()};
    EXPECT_EQ(decode(bytes, batch), DropReason::none);
    batch.samples[0].client_time += Nanoseconds(1);
    const Bytes other = encoder.samples(batch);
    payload.assign(other.begin(), other.end());
    return true;
  });
  EXPECT_TRUE(replay({file}).difference.has_value());
}

TEST_F(ReplayTest, ChangedSceneIsFound) {
  const auto file = record();
  EXPECT_TRUE(
      replay({file}, std::make_shared<const Scene>(load_scene(repository_scene("room.json"))))
          .bit_equal());
  std::ifstream in(repository_scene("room.json"));
  std::ostringstream text;
  text << in.rdbuf();
  std::string changed = text.str();
  const auto at = changed.find("\"stiffness\": 900,");  // This is the table under the hands.
  ASSERT_NE(at, std::string::npos);
  changed.replace(at, std::string_view("\"stiffness\": 900,").size(), "\"stiffness\": 901,");
  const auto other =
      std::make_shared<const Scene>(parse_scene(changed, repository_scene("room.json").string()));
  EXPECT_FALSE(replay({file}, other).bit_equal());
}

TEST_F(ReplayTest, CutFileIsReplayedUpToTheCut) {
  scene.join(kA);
  scene.run(4000);
  const auto file = scene.finish();
  const Replay whole = replay({file});
  const auto size = std::filesystem::file_size(file);
  std::filesystem::resize_file(file, size * 6 / 10);
  const Replay cut = replay({file});
  EXPECT_TRUE(cut.cut_at.has_value());
  EXPECT_FALSE(cut.difference.has_value());
  EXPECT_TRUE(cut.bit_equal());
  EXPECT_LT(cut.events, whole.events);
  EXPECT_GT(cut.events, whole.events / 4);
}

TEST_F(ReplayTest, MissingEventIsSaid) {
  const auto file = record();
  test::rewrite(file, [](RecordedEvent& event, std::string&) { return event.number != 100; });
  const Replay result = replay({file});
  EXPECT_EQ(result.lost, 1u);
  EXPECT_EQ(result.events, 99u);
  EXPECT_FALSE(result.bit_equal());
}

/// A full log must not stop the answers to a hand.
TEST(Replay, FullLogIsCountedAndMarkedInTheFile) {
  RecordedScene scene(repository_scene("plane.json"), 1 << 12);
  scene.join(kA);
  scene.run(20);
  for (int n = 0; n < 100; ++n) {  // No thread takes the events.
    scene.exchange.now += std::chrono::milliseconds(1);
    EXPECT_FALSE(scene.exchange.send(kA, test::hand(1), false).empty());
  }
  EXPECT_GT(scene.log.lost(), 0u);
  scene.run(20);
  const Replay result = replay({scene.finish()});
  EXPECT_EQ(result.lost, scene.log.lost());
  EXPECT_FALSE(result.bit_equal());
}

TEST(Replay, PartsGoTogetherInTheirOrder) {
  RecordedScene scene(repository_scene("plane.json"), 1 << 20, {.seconds = 0.1});
  scene.join(kA);
  scene.run(250);
  scene.finish();
  const auto part = [&](int n) { return numbered(scene.file, {.seconds = 1.0}, n); };
  EXPECT_TRUE(replay({part(1), part(2), part(3)}).bit_equal());
  EXPECT_TRUE(replay({part(1)}).bit_equal());
  EXPECT_GT(replay({part(1), part(3)}).lost, 0u);
  const auto refusal = [](const std::vector<std::filesystem::path>& files) {
    try {
      replay(files);
    } catch (const FileError& error) {
      return std::string(error.what());
    }
    return std::string();
  };
  EXPECT_THAT(refusal({part(2)}), HasSubstr("give all files of the recording"));
  EXPECT_THAT(refusal({part(1), part(1)}), HasSubstr("each once"));
}

/// Session keys must not be in the file. The server keeps them only during the session.
TEST_F(ReplayTest, KeysAreNotInTheFile) {
  const auto file = record();
  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file.string());
  std::string all;
  while (const auto message = reader.next()) all += message->data;
  for (const auto& attachment : reader.attachments()) all += attachment.data;
  ASSERT_THAT(all, HasSubstr("tester"));  // the name of the client
  for (const std::uint64_t id : {kA, kB}) {
    const SessionKeys keys = test::keys(id);
    for (const Key* key : {&keys.up, &keys.down})
      EXPECT_EQ(all.find(std::string(key->begin(), key->begin() + 8)), std::string::npos);
  }
}

/// For numbers that no server writes, the replay must report an error or a difference.
TEST_F(ReplayTest, HostileEventsHarmNothing) {
  const auto file = record();
  const auto original = file.string() + ".original";
  std::filesystem::copy_file(file, original);
  int refused = 0, different = 0;
  for (std::uint64_t seed = 0; seed < 60; ++seed) {
    std::filesystem::copy_file(original, file, std::filesystem::copy_options::overwrite_existing);
    const std::uint64_t at = 1 + splitmix::draw(seed, 0) % 40;
    const std::uint64_t value = splitmix::draw(seed, 1) >> (splitmix::draw(seed, 2) % 64);
    test::rewrite(file, [&](RecordedEvent& event, std::string& payload) {
      if (event.number != at) return true;
      switch (seed % 6) {
        case 0:
          event.kind = value % 16;
          break;
        case 1:
          event.time = value;
          break;
        case 2:
          event.hand = value;
          break;
        case 3:
          event.outcome = value % 8;
          break;
        case 4:
          for (char& byte : payload) byte = static_cast<char>(byte ^ static_cast<char>(value));
          break;
        default:
          payload.resize(value % 100);
          break;
      }
      return true;
    });
    try {
      different += replay({file}).bit_equal() ? 0 : 1;
    } catch (const FileError&) {
      ++refused;
    }
  }
  EXPECT_GT(refused, 0);
  EXPECT_GT(different, 20);
}

TEST(Replay, FilesWithoutAnInputLogAreRefused) {
  const testing::TemporaryFolder folder;
  const auto file = folder / "no.mcap";
  mcap::Writer writer;
  writer.finish();
  std::ofstream(file, std::ios::binary) << writer.take();
  EXPECT_THROW(replay({file}), FileError);
  EXPECT_THROW(replay({folder / "missing.mcap"}), FileError);
}

/// The scene's thread must not allocate for the recorder.
TEST(Replay, RecordingAllocatesNothingOnTheServoPath) {
  RecordedScene scene(repository_scene("room.json"));
  scene.join(kA);
  scene.run(100);
  scene.exchange.allocated = 0;
  scene.run(100);
  EXPECT_EQ(scene.exchange.allocated, 0u);
}

}  // namespace
}  // namespace feltwire::replay_test

// A scene's own thread serves the scene while another thread records it.

#include "server/recording/recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <algorithm>
#include <asio/io_context.hpp>
#include <future>

#include "core/scene_file/load_scene.hpp"
#include "server/recording/scene_replay.hpp"
#include "server/scene/scene_host.hpp"
#include "tests/server/raw_socket.hpp"
#include "tests/server/recording/recorded_scene.hpp"
#include "tests/support/eventually.hpp"

namespace feltwire::recorder_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

constexpr std::uint64_t kId = 0x100;
constexpr std::uint64_t kSamples = 300;

std::vector<Scene> scenes() {
  std::vector<Scene> all;
  all.push_back(load_scene_and_keep(test::repository_scene("room.json")));
  return all;
}

/// A host on a free port with a session.
struct Served {
  explicit Served(const RecorderOptions& options) : loaded(scenes()), recorder(options, loaded) {
    SceneHostOptions host_options;
    host_options.address = asio::ip::make_address("127.0.0.1");
    host_options.silence_timeout = 100s;
    host_options.limits.sample_rate = 1e6;
    host_options.events = &recorder.log(0);
    host = std::make_unique<SceneHost>(std::move(loaded.front()), host_options);
    recorder.see(0, host->recorded_pictures(), host.get());
    host->start();
    recorder.start();
    host->ask(test::join_request(), kId, test::keys(kId), io, [](const control::Message&) {});
    socket = std::make_unique<test::RawSocket>(SOCK_DGRAM, host->port());
  }
  ~Served() { stop(); }
  Served(const Served&) = delete;
  Served& operator=(const Served&) = delete;

  /// Sends samples and waits for each answer.
  void exchange(std::uint64_t samples) {
    for (std::uint64_t n = 0; n < samples; ++n) {
      ++packet;
      socket->send(encoder.samples(kId, packet, test::hand_batch(packet)));
      ASSERT_FALSE(socket->receive().empty()) << packet;
    }
  }
  void stop() {
    host->stop();
    recorder.stop();
  }

  std::vector<Scene> loaded;
  asio::io_context io{1};
  Recorder recorder;
  std::unique_ptr<SceneHost> host;
  std::unique_ptr<test::RawSocket> socket;
  test::SealedEncoder encoder{test::Way::up};
  std::uint64_t packet = 0;
};

std::size_t messages_of(const std::filesystem::path& file, const std::string& topic) {
  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file.string());
  std::size_t count = 0;
  while (const auto message = reader.next())
    count += reader.channels().at(message->channel).topic == topic ? 1 : 0;
  return count;
}

/// The metadata record `scene` of a file, and its messages of /scene/geometry.
struct Shown {
  std::string message, geometry;
  bool operator==(const Shown&) const = default;
};
Shown shown_in(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file.string());
  Shown shown;
  while (const auto message = reader.next())
    if (reader.channels().at(message->channel).topic == "/scene/geometry")
      shown.geometry += message->data;
  for (const mcap::Metadata& metadata : reader.metadata())
    if (metadata.name == "scene") shown.message = metadata.values.at("message");
  return shown;
}

TEST(Recorder, EachFileDescribesTheSceneUntilAReload) {
  const testing::TemporaryFolder folder;
  SceneRecording recording({.file = folder / "room.mcap",
                            .limits = {.seconds = 1.0},
                            .shown = {.message = "message", .geometry = "triangles"}},
                           nullptr, 0);
  const auto add = [&](int second, EventKind kind) {
    recording.add({.kind = kind, .time = std::chrono::seconds(second)});
  };
  add(1, EventKind::join);
  add(3, EventKind::reload);
  add(5, EventKind::tick);
  recording.finish();
  EXPECT_EQ(shown_in(folder / "room-0001.mcap"), (Shown{"message", "triangles"}));
  EXPECT_EQ(shown_in(folder / "room-0002.mcap"), (Shown{"message", "triangles"}));
  EXPECT_EQ(shown_in(folder / "room-0003.mcap"), Shown{});
}

/// A large scene does not make a file of each message.
TEST(Recorder, TheDescriptionOfTheSceneCountsForNoLimit) {
  const testing::TemporaryFolder folder;
  std::string triangles(std::size_t{1} << 20, ' ');
  for (std::size_t i = 0; i < triangles.size(); ++i)
    triangles[i] = static_cast<char>(i * i * i >> 7);  // It is not small when it is compressed.
  SceneRecording recording({.file = folder / "room.mcap",
                            .limits = {.mebibytes = 0.01},
                            .shown = {.message = "message", .geometry = triangles}},
                           nullptr, 0);
  for (int second = 1; second < 4; ++second)
    recording.add({.kind = EventKind::tick, .time = std::chrono::seconds(second)});
  recording.finish();
  EXPECT_GT(std::filesystem::file_size(folder / "room-0001.mcap"), std::size_t{20'000});
  EXPECT_EQ(messages_of(folder / "room-0001.mcap", "/scene/events"), 3u);
  EXPECT_FALSE(std::filesystem::exists(folder / "room-0002.mcap"));
}

TEST(Recorder, ServedSceneIsReplayedBitEqual) {
  const testing::TemporaryFolder folder;
  const auto file = folder / "room.mcap";
  Served served({.file = file});
  served.exchange(kSamples);
  served.host->reload(load_scene_and_keep(test::repository_scene("room.json")));
  served.exchange(kSamples);
  // The recorder takes pictures at its own times.
  ASSERT_TRUE(test::becomes([&] {
    served.exchange(1);
    return messages_of(file, "/scene/picture") > 0;
  }));
  served.stop();
  const Replay result = replay({file});
  EXPECT_TRUE(result.bit_equal()) << (result.difference ? result.difference->what : "");
  EXPECT_EQ(result.replies, served.packet);
  EXPECT_EQ(result.sessions, 1u);
  EXPECT_EQ(result.lost, 0u);
}

TEST(Recorder, EvictionGivesAFlightRecord) {
  const testing::TemporaryFolder folder;
  Served served({.flight_folder = folder / "flights"});
  served.exchange(kSamples);
  const auto flights = [&] {
    return std::distance(std::filesystem::directory_iterator(folder / "flights"),
                         std::filesystem::directory_iterator());
  };
  served.recorder.ask_for_flight_records();
  ASSERT_TRUE(test::becomes([&] { return flights() == 1; }));
  served.host->evict(kId);
  served.stop();  // This call writes the pending files.
  EXPECT_EQ(flights(), 2);
}

TEST(Recorder, AFlightRecordThatIsAskedForIsNamed) {
  const testing::TemporaryFolder folder;
  Served served({.flight_folder = folder / "flights"});
  served.exchange(kSamples);
  const auto asked = [&] {
    std::promise<std::optional<std::filesystem::path>> written;
    served.recorder.ask_for_flight_record(
        0, [&](std::optional<std::filesystem::path> file) { written.set_value(std::move(file)); });
    return written.get_future().get();
  };
  const auto file = asked();
  ASSERT_TRUE(file.has_value());
  // The join is also an event, and so is a check for each second of the samples.
  EXPECT_GE(messages_of(*file, "/scene/events"), kSamples + 1);
  std::filesystem::remove_all(folder / "flights");
  EXPECT_EQ(asked(), std::nullopt);
}

/// Asks the recorder of the only scene, and returns its answer.
control::SceneRecordings recordings(Served& served, control::RecordingAction action) {
  std::promise<std::variant<control::SceneRecordings, control::Refused>> told;
  served.recorder.record(0, action, [&](auto outcome) { told.set_value(std::move(outcome)); });
  return std::get<control::SceneRecordings>(told.get_future().get());
}

TEST(Recorder, ARecordingThatAnAdminStartsHasWhatFollows) {
  const testing::TemporaryFolder folder;
  AskedRecordingOptions asked;
  asked.folder = folder / "recordings";
  Served served({.asked = asked, .describe = [](const Scene& scene) {
                   return SceneToShow{scene.name(), "triangles"};
                 }});
  served.exchange(kSamples);
  EXPECT_EQ(recordings(served, control::RecordingAction::look).running, "");
  const auto begun = recordings(served, control::RecordingAction::start);
  EXPECT_NE(begun.running, "");
  served.exchange(kSamples);
  const auto ended = recordings(served, control::RecordingAction::stop);
  ASSERT_EQ(ended.kept.size(), 1u);
  EXPECT_EQ(ended.kept[0].name, begun.running);
  const std::size_t events = messages_of(asked.folder / ended.kept[0].name, "/scene/events");
  EXPECT_GE(events, kSamples);
  EXPECT_LT(events, 2 * kSamples);
  EXPECT_EQ(shown_in(asked.folder / ended.kept[0].name), (Shown{"room", "triangles"}));
}

/// A file with an index and an end is complete.
TEST(Recorder, AServerThatEndsClosesTheRecording) {
  const testing::TemporaryFolder folder;
  AskedRecordingOptions asked;
  asked.folder = folder / "recordings";
  Served served({.asked = asked});
  const auto begun = recordings(served, control::RecordingAction::start);
  served.exchange(kSamples);
  served.stop();
  std::ifstream in(asked.folder / begun.running, std::ios::binary);
  const std::string bytes{std::istreambuf_iterator<char>(in), {}};
  constexpr std::string_view kMagic = "\x89MCAP0\r\n";
  EXPECT_TRUE(bytes.ends_with(kMagic));
  EXPECT_GE(messages_of(asked.folder / begun.running, "/scene/events"), kSamples);
}

TEST(Recorder, FileThatCannotBeWrittenIsNamed) {
  try {
    const Recorder recorder({.file = "/dev/null/room.mcap"}, scenes());
    FAIL();
  } catch (const std::runtime_error& error) {
    EXPECT_THAT(error.what(), HasSubstr("/dev/null/room.mcap"));
    EXPECT_THAT(error.what(), HasSubstr("--record"));
  }
}

TEST(Recorder, EachSceneHasAFile) {
  EXPECT_EQ(recording_file("a/b.mcap", {"room"}, 0), "a/b.mcap");
  EXPECT_EQ(recording_file("a/b.mcap", {"room", "wall"}, 1), "a/b-wall.mcap");
  EXPECT_EQ(recording_file("b.mcap", {"../x", "__/x"}, 0), "b-___x-1.mcap");
  EXPECT_EQ(recording_file("b.mcap", {"../x", "__/x"}, 1), "b-___x-2.mcap");
}

}  // namespace
}  // namespace feltwire::recorder_test

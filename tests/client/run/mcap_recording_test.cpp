#include "client/run/mcap_recording.hpp"

#include <gmock/gmock.h>
#include <signal.h>
#include <sys/resource.h>

#include <cmath>
#include <regex>

#include "client/run/records.hpp"
#include "core/recording/sample_messages.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/recording/recordings.hpp"

namespace feltwire::mcap_recording_test {
namespace {

using test::keep_recording;
using test::read_mcap;
using test::ReadFile;
using test::ReadMessage;
using testing::text_of;

constexpr std::int64_t kMillisecond = 1'000'000;
constexpr std::int64_t kOffset = 1'700'000'000'000'000'000;  // [ns] late in 2023

/// Returns one tick per millisecond of a hand that presses.
TickRecord tick(int n) {
  const double depth = 1e-3 * std::sin(0.01 * n);
  return {.time = 0.001 * n,
          .position = {0.01, 0.0, -depth},
          .elastic = {0.0, 0.0, 1000.0 * depth},
          .held = {0.0, 0.1, 900.0 * depth},
          .age = 0.001,
          .clock = kMillisecond * n,
          .orientation = Quaternion(0.6, 0.8, 0.0, 0.0),
          .torque = {0.0, 0.0, 0.002},
          .balance = n < 10 ? std::nullopt : std::optional(1e-6 * n),
          .account_cut = 0.1,
          .no_force = n % 2 == 0 ? ZeroForceReason::felt : ZeroForceReason::account};
}

/// Writes a few ticks at a time, as the writing thread does.
void record(Recorder& recorder, int from, int end) {
  Ring<TickRecord> rows(64);
  for (int n = from; n < end;) {
    for (int i = 0; i < 50 && n < end; ++i) rows.push(tick(n++));
    recorder.write(rows);
  }
}

ReadFile read(const std::filesystem::path& path) {
  const std::string bytes = text_of(path);
  keep_recording(path.filename(), bytes);
  return read_mcap(bytes);
}

std::vector<RecordedSample> samples_of(const ReadFile& file) {
  std::vector<RecordedSample> samples;
  for (const ReadMessage& message : file.messages)
    if (message.topic == "/hand/sample") samples.push_back(read_sample(message.data).value());
  return samples;
}

std::size_t count(const ReadFile& file, const std::string& topic) {
  return static_cast<std::size_t>(
      std::count_if(file.messages.begin(), file.messages.end(),
                    [&](const ReadMessage& message) { return message.topic == topic; }));
}

TEST(McapRecording, HasAllOfEachTick) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "ticks.mcap";
  McapRecording recording({.file = path, .about = {{"scene", "plane"}}}, kOffset);
  record(recording, 0, 1000);
  recording.finish();

  const ReadFile file = read(path);
  EXPECT_FALSE(file.cut_at);
  EXPECT_EQ(file.metadata.at(0).values.at("scene"), "plane");
  const auto samples = samples_of(file);
  ASSERT_EQ(samples.size(), 1000u);
  for (int n = 0; n < 1000; ++n) {
    const TickRecord row = tick(n);
    const RecordedSample& sample = samples[static_cast<std::size_t>(n)];
    ASSERT_EQ(sample.time, row.time);
    ASSERT_EQ(sample.pose.position, row.position);
    ASSERT_EQ(sample.pose.orientation.coeffs(), row.orientation.coeffs());
    ASSERT_EQ(sample.elastic, row.elastic);
    ASSERT_EQ(sample.frictional, row.frictional);
    ASSERT_EQ(sample.held, row.held);
    ASSERT_EQ(sample.torque, row.torque);
    ASSERT_EQ(sample.age, row.age);
  }
  int n = 0;
  for (const ReadMessage& message : file.messages) {
    if (message.topic != "/hand/account") continue;
    const RecordedAccount account = read_account(message.data).value();
    const TickRecord row = tick(n);
    ASSERT_EQ(message.time, static_cast<std::uint64_t>(kOffset + row.clock));
    ASSERT_EQ(account.time, row.time);
    ASSERT_EQ(account.balance, row.balance);
    ASSERT_EQ(account.cut, row.account_cut);
    ASSERT_EQ(account.no_force, static_cast<std::uint32_t>(row.no_force));
    ++n;
  }
  EXPECT_EQ(n, 1000);
  // A second has 60 pictures.
  EXPECT_EQ(count(file, "/hand/pose"), 60u);
  EXPECT_EQ(count(file, "/hand/picture"), 60u);
}

/// A reader must find all but the last second, as after a kill of the program.
TEST(McapRecording, IsReadableWhileItIsWritten) {
  const testing::TemporaryFolder folder;
  McapRecording recording({.file = folder / "open.mcap"}, kOffset);
  EXPECT_TRUE(read(folder / "open.mcap").cut_at);
  record(recording, 0, 3500);
  const ReadFile file = read(folder / "open.mcap");
  EXPECT_TRUE(file.cut_at);
  EXPECT_GE(samples_of(file).size(), 2500u);
}

/// A second of scene views at 100 Hz shows a hand and a body. The hand then leaves.
TEST(McapRecording, HasWhatAnObserverSees) {
  const testing::TemporaryFolder folder;
  int asked = 0;
  {
    Records records({.recording = RecordingTarget{folder / "observer.mcap"},
                     .view = {},
                     .observes = true,
                     .on_view = [&](double, const ObservedScene&) { ++asked; }});
    for (int n = 0; n <= 1000; ++n) {
      records.rows()->push(tick(n));
      if (n % 10 == 0) {
        SceneView view;
        view.present = true;
        view.hands_end = SceneView::kLastHand;
        view.bodies_end = SceneView::kLastBody;
        if (n < 1000)
          view.hand[view.hand_count++] = {7, Pose{.position = {0.5, 0, 0}}, Vec3(0, 0, 1.5)};
        view.body[view.body_count++] = {3, Pose{}};
        records.views()->push({0.001 * n, view});
      }
      records.write();
    }
    records.finish();
    EXPECT_FALSE(records.failed());
  }
  EXPECT_EQ(asked, 101);
  const ReadFile file = read(folder / "observer.mcap");
  std::vector<ReadMessage> seen;
  for (const ReadMessage& message : file.messages)
    if (message.topic == "/scene/picture") seen.push_back(message);
  // 60 Hz pictures from 100 Hz views are 50 or 60 pictures. One more picture removes the hand.
  EXPECT_GE(seen.size(), 50u);
  EXPECT_LE(seen.size(), 62u);
  EXPECT_THAT(seen.front().data, ::testing::HasSubstr("hand 7"));
  EXPECT_THAT(seen.front().data, ::testing::HasSubstr("body 3"));
  constexpr char kDeletion = 0x0a;  // field 1 of a SceneUpdate
  EXPECT_NE(seen.front().data.front(), kDeletion);
  EXPECT_EQ(seen.back().data.front(), kDeletion);
  EXPECT_THAT(seen.back().data, ::testing::HasSubstr("hand 7"));
  EXPECT_EQ(seen.back().time - seen.front().time, 1'000'000'000u);
}

TEST(McapRecording, FilesAreNumberedByTime) {
  const testing::TemporaryFolder folder;
  McapRecording recording({.file = folder / "hand.mcap", .limits = {.seconds = 1.0}}, kOffset);
  record(recording, 0, 2500);
  recording.finish();
  EXPECT_EQ(folder.entries(), 3u);
  int n = 0;
  for (int part = 1; part <= 3; ++part) {
    const ReadFile file = read(folder / ("hand-000" + std::to_string(part) + ".mcap"));
    EXPECT_FALSE(file.cut_at);
    EXPECT_EQ(file.metadata.at(0).values.at("part"), std::to_string(part));
    EXPECT_EQ(samples_of(file).size(), part < 3 ? 1000u : 500u);
    for (const RecordedSample& sample : samples_of(file)) ASSERT_EQ(sample.time, tick(n++).time);
  }
  EXPECT_EQ(n, 2500);
}

TEST(McapRecording, FilesAreNumberedBySize) {
  const testing::TemporaryFolder folder;
  constexpr double kMebibytes = 0.1;
  McapRecording recording({.file = folder / "sized.mcap", .limits = {.mebibytes = kMebibytes}},
                          kOffset);
  record(recording, 0, 5000);
  recording.finish();
  ASSERT_GE(folder.entries(), 3u);
  std::size_t n = 0;
  for (std::size_t part = 1; part <= folder.entries(); ++part) {
    const auto path = folder / ("sized-000" + std::to_string(part) + ".mcap");
    // The limit allows an extra chunk and the end of the file.
    EXPECT_LT(std::filesystem::file_size(path), kMebibytes * (1 << 20) + 150'000.0);
    n += samples_of(read(path)).size();
  }
  EXPECT_EQ(n, 5000u);
}

TEST(McapRecording, TheEndingOfTheNameChoosesTheFormat) {
  const testing::TemporaryFolder folder;
  open_recording({.file = folder / "a.mcap"});
  open_recording({.file = folder / "a.csv"});
  EXPECT_EQ(text_of(folder / "a.mcap").substr(1, 4), "MCAP");
  EXPECT_EQ(text_of(folder / "a.csv").substr(0, 4), "t,x,");
  EXPECT_EQ(numbered({.file = "out/a.mcap"}, 1), "out/a.mcap");
  EXPECT_EQ(numbered({.file = "out/a.mcap", .limits = {.seconds = 60.0}}, 12345),
            "out/a-12345.mcap");
}

TEST(McapRecording, SaysWhyItCannotBeWritten) {
  EXPECT_THAT(testing::error_of<std::runtime_error>(
                  [] { McapRecording({.file = "/proc/nowhere/at/all.mcap"}); }),
              ::testing::HasSubstr("/proc/nowhere/at/all.mcap: No such file or directory"));
  EXPECT_THAT(testing::error_of<std::runtime_error>([] { McapRecording({.file = "/dev/full"}); }),
              ::testing::HasSubstr("No space left"));
}

/// Complete chunks must stay readable after the disk is full.
TEST(McapRecording, OnAFullDiskKeepsWholeRecords) {
  const testing::TemporaryFolder folder;
  const auto path = folder / "full.mcap";
  ::signal(SIGXFSZ, SIG_IGN);
  rlimit before{};
  ::getrlimit(RLIMIT_FSIZE, &before);
  constexpr rlim_t kMost = 150'000;
  const rlimit less{kMost, before.rlim_max};
  ::setrlimit(RLIMIT_FSIZE, &less);
  McapRecording recording({.file = path}, kOffset);
  const std::string error =
      testing::error_of<std::runtime_error>([&] { record(recording, 0, 10'000); });
  ::setrlimit(RLIMIT_FSIZE, &before);
  ::signal(SIGXFSZ, SIG_DFL);
  EXPECT_THAT(error, ::testing::HasSubstr("full.mcap ends here: File too large; make room"));
  const ReadFile file = read(path);
  EXPECT_EQ(file.cut_at, std::filesystem::file_size(path));
  EXPECT_GT(samples_of(file).size(), 100u);
}

/// The schema and the report must use the same names.
TEST(McapRecording, TheReasonsAreThoseOfTheReport) {
  const std::string proto =
      text_of(std::string(FELTWIRE_SOURCE_DIR) + "/core/recording/feltwire.proto");
  const std::string list = proto.substr(proto.find("enum NoForce {"));
  const std::regex line(R"((\w+) = (\d+);)");
  const std::string reasons = list.substr(0, list.find('}'));
  std::size_t n = 0;
  for (std::sregex_iterator at(reasons.begin(), reasons.end(), line), end; at != end; ++at, ++n) {
    ASSERT_EQ((*at)[2].str(), std::to_string(n));
    ASSERT_EQ((*at)[1].str(), name(static_cast<ZeroForceReason>(n)));
  }
  EXPECT_EQ(n, kZeroForceReasons);
}

}  // namespace
}  // namespace feltwire::mcap_recording_test

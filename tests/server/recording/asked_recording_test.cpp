// An admin starts and stops recordings of a scene. Each ends by itself at its limits.

#include "server/recording/asked_recording.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <fstream>
#include <limits>

#include "core/base/file_error.hpp"
#include "tests/server/recording/recorded_scene.hpp"

namespace feltwire::asked_recording_test {
namespace {

using namespace std::chrono_literals;
using control::RecordingAction;
using control::RecordingEnd;
using control::Refused;
using control::SceneRecordings;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::MatchesRegex;
using ::testing::SizeIs;
namespace fs = std::filesystem;

constexpr std::uint64_t kHand = 0x100;

class AskedRecordingTest : public ::testing::Test {
 protected:
  AskedRecordingTest() {
    options_.folder = scene_.folder / "recordings";
    options_.room = [this](const fs::path&) { return room_; };
    scene_.join(kHand);
  }
  /// Makes the recordings with the present options.
  void make() { asked_.emplace(options_, "plane", "plane", 0); }
  SceneRecordings act(RecordingAction action) {
    return std::get<SceneRecordings>(asked_->act(action, scene_.exchange.now));
  }
  std::string refused(RecordingAction action) {
    return std::get<Refused>(asked_->act(action, scene_.exchange.now)).reason;
  }
  SceneRecordings look() { return act(RecordingAction::look); }
  /// Runs the hand, and the recording beside it as the recorder does.
  void run(int milliseconds) {
    for (int n = 0; n < milliseconds; ++n) {
      scene_.exchange.now += 1ms;
      scene_.exchange.send(kHand, test::hand(scene_.exchange.index[kHand] + 1), false);
      while (const auto event = scene_.log.take()) asked_->add(*event);
      if (n % 10 == 9) asked_->look_after(scene_.exchange.now);
    }
  }
  std::size_t events(const std::string& name) {
    std::ifstream in(options_.folder / name, std::ios::binary);
    mcap::Reader reader(in, name);
    std::size_t count = 0;
    while (const auto message = reader.next())
      count += reader.channels().at(message->channel).topic == "/scene/events" ? 1 : 0;
    return count;
  }
  bool is_complete(const std::string& name) {
    std::ifstream in(options_.folder / name, std::ios::binary);
    const std::string bytes{std::istreambuf_iterator<char>(in), {}};
    return bytes.ends_with("\x89MCAP0\r\n");
  }

  test::RecordedScene scene_{test::repository_scene("plane.json")};
  AskedRecordingOptions options_;
  std::optional<std::uintmax_t> room_ = std::numeric_limits<std::uintmax_t>::max();
  std::optional<AskedRecording> asked_;
};

TEST_F(AskedRecordingTest, HasWhatComesFromItsStartToItsStop) {
  make();
  run(100);
  EXPECT_THAT(look().kept, IsEmpty());
  const SceneRecordings begun = act(RecordingAction::start);
  EXPECT_THAT(begun.running, MatchesRegex("recording-[0-9]{8}T[0-9]{6}\\.[0-9]{3}Z-plane\\.mcap"));
  EXPECT_THAT(begun.kept, IsEmpty());
  EXPECT_THAT(refused(RecordingAction::start), HasSubstr("runs already"));
  run(2000);
  const SceneRecordings during = look();
  EXPECT_EQ(during.running, begun.running);
  EXPECT_DOUBLE_EQ(during.seconds, 2.0);
  EXPECT_GT(during.bytes, begun.bytes);
  EXPECT_EQ(during.ended, RecordingEnd::none);
  const SceneRecordings ended = act(RecordingAction::stop);
  EXPECT_EQ(ended.running, "");
  EXPECT_EQ(ended.ended, RecordingEnd::asked);
  EXPECT_DOUBLE_EQ(ended.seconds, 2.0);
  ASSERT_THAT(ended.kept, SizeIs(1));
  EXPECT_EQ(ended.kept[0].name, begun.running);
  const fs::path file = options_.folder / begun.running;
  EXPECT_EQ(ended.kept[0].bytes, fs::file_size(file));
  EXPECT_EQ(ended.bytes, fs::file_size(file));
  EXPECT_EQ(fs::status(file).permissions(), fs::perms::owner_read | fs::perms::owner_write);
  EXPECT_TRUE(is_complete(begun.running));
  run(100);
  EXPECT_EQ(events(begun.running), 2000u);
  EXPECT_THAT(refused(RecordingAction::stop), HasSubstr("no recording of the scene runs"));
}

TEST_F(AskedRecordingTest, EndsAtItsLongestTime) {
  options_.limits.seconds = 1.5;
  make();
  const std::string name = act(RecordingAction::start).running;
  run(1490);
  EXPECT_EQ(look().running, name);
  run(10);
  EXPECT_EQ(look().running, "");
  EXPECT_EQ(look().ended, RecordingEnd::time);
  EXPECT_TRUE(is_complete(name));
  EXPECT_NE(act(RecordingAction::start).running, "");
}

TEST_F(AskedRecordingTest, EndsAtItsLargestSize) {
  options_.limits.mebibytes = 0.25;
  make();
  const std::string name = act(RecordingAction::start).running;
  for (int n = 0; n < 60 && look().ended == RecordingEnd::none; ++n) run(1000);
  EXPECT_EQ(look().ended, RecordingEnd::size);
  EXPECT_TRUE(is_complete(name));
  // A chunk of 256 KiB and the index may come on top.
  EXPECT_GE(look().kept.at(0).bytes, std::uintmax_t{256} << 10);
  EXPECT_LT(look().kept.at(0).bytes, std::uintmax_t{1} << 20);
}

TEST_F(AskedRecordingTest, EndsWhereTheDiskHasTooLittleRoom) {
  make();
  room_ = options_.least_room - 1;
  EXPECT_THAT(refused(RecordingAction::start), HasSubstr("too little room"));
  room_ = std::nullopt;  // Some file systems do not say.
  const std::string name = act(RecordingAction::start).running;
  run(1000);
  EXPECT_EQ(look().running, name);
  room_ = options_.least_room - 1;
  run(1000);
  EXPECT_EQ(look().ended, RecordingEnd::room);
  EXPECT_TRUE(is_complete(name));
}

TEST_F(AskedRecordingTest, KeepsTheNewestFilesOfItsScene) {
  make();
  const auto old = [&](int number, const std::string& scene) {
    std::string digits = std::to_string(number);
    digits.insert(0, 3 - digits.size(), '0');
    return "recording-19690101T000000." + digits + "Z-" + scene + ".mcap";
  };
  const int many = static_cast<int>(AskedRecordingOptions::kMostFiles) + 3;
  for (int n = 0; n < many; ++n) std::ofstream(options_.folder / old(n, "plane")) << n;
  std::ofstream(options_.folder / old(0, "other-plane")) << "another scene's";
  std::ofstream(options_.folder / "notes.txt") << "no recording";
  act(RecordingAction::start);
  const SceneRecordings ended = act(RecordingAction::stop);
  ASSERT_THAT(ended.kept, SizeIs(AskedRecordingOptions::kMostFiles));
  EXPECT_EQ(ended.kept[1].name, old(many - 1, "plane"));  // The newest is first.
  EXPECT_EQ(ended.kept.back().name, old(4, "plane"));
  EXPECT_TRUE(fs::exists(options_.folder / old(0, "other-plane")));
  EXPECT_TRUE(fs::exists(options_.folder / "notes.txt"));
}

TEST_F(AskedRecordingTest, AFolderThatIsGoneIsSaid) {
  make();
  fs::remove_all(options_.folder);
  EXPECT_THAT(refused(RecordingAction::start), HasSubstr("the server's log says why"));
  EXPECT_EQ(look().running, "");
  options_.folder = "/dev/null/recordings";
  try {
    make();
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("--recordings"));
  }
}

TEST_F(AskedRecordingTest, TheEndOfTheServerClosesTheFile) {
  make();
  const std::string name = act(RecordingAction::start).running;
  run(100);
  asked_->finish();
  EXPECT_TRUE(is_complete(name));
  EXPECT_EQ(events(name), 101u);  // The join is one, too.
}

}  // namespace
}  // namespace feltwire::asked_recording_test

// When a session ends, the recorder writes the last seconds of the scene to a file. No file is
// written if the client ended the session.

#include "server/recording/flight_recorder.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "core/base/file_error.hpp"
#include "core/recording/flight_files.hpp"
#include "core/recording/mcap_reader.hpp"
#include "tests/core/recording/recordings.hpp"
#include "tests/server/recording/recorded_scene.hpp"

namespace feltwire::flight_recorder_test {
namespace {

using namespace std::chrono_literals;
using test::files_in;
using ::testing::HasSubstr;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr std::uint64_t kA = 0x100, kB = 0x200;

struct Read {
  std::string reason;
  std::vector<RecordedEvent> events;
  std::size_t pictures = 0;
};
Read read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file.string());
  Read result;
  while (const auto message = reader.next()) {
    if (reader.channels().at(message->channel).topic == "/scene/picture") ++result.pictures;
    if (reader.channels().at(message->channel).topic == "/scene/events") {
      result.events.push_back(*read_event(message->data));
      result.events.back().payload = {};
    }
  }
  result.reason = reader.metadata().front().values.at("reason");
  return result;
}

/// Records two hands for 12 s, which is longer than the recorder keeps.
class FlightRecorderTest : public ::testing::Test {
 protected:
  test::RecordedScene scene{test::repository_scene("plane.json")};
  std::filesystem::path folder = scene.folder / "flights";
  FlightRecorder flight{folder, "scene", {{"scene", "plane"}}, 0};

  void take() {
    while (const auto event = scene.log.take()) flight.add(*event);
  }
  void run(int milliseconds) {
    for (int n = 0; n < milliseconds; ++n) {
      scene.exchange.now += 1ms;
      for (const std::uint64_t id : {kA, kB})
        if (scene.exchange.sessions.find(id) != nullptr)
          scene.exchange.send(id, test::hand(scene.exchange.index[id] + 1), false);
      take();
    }
  }
  void TearDown() override { test::keep_recordings("server", folder); }
  void SetUp() override {
    scene.join(kA);
    scene.join(kB);
    run(12000);
  }
};

TEST_F(FlightRecorderTest, EvictionIsWrittenWithTheLastTenSeconds) {
  flight.write_if_due(false, scene.exchange.now);
  EXPECT_THAT(files_in(folder), IsEmpty());
  scene.exchange.sessions.evict(kB);
  take();
  flight.write_if_due(false, scene.exchange.now);  // Simultaneous causes share a file.
  EXPECT_THAT(files_in(folder), IsEmpty());
  flight.write_if_due(false, scene.exchange.now + FlightRecorder::kTogether);
  ASSERT_THAT(files_in(folder), SizeIs(1));
  const Read file = read(files_in(folder).front());
  EXPECT_EQ(file.reason, "hand 2: it was evicted");
  ASSERT_FALSE(file.events.empty());
  const auto newest = static_cast<std::uint64_t>(scene.exchange.now.count());
  EXPECT_EQ(file.events.back().kind, static_cast<std::uint64_t>(EventKind::end));
  EXPECT_EQ(file.events.front().time, newest - 10'000'000'000u);
  EXPECT_EQ(file.events.size(), 2u * 10'001u + 1u);
  EXPECT_NEAR(static_cast<double>(file.pictures), 600.0, 10.0);
}

/// A lasting debt counts once. Further debts within ten seconds of a file do not count.
TEST_F(FlightRecorderTest, ADebtThatAClientTellsOfIsWrittenOnce) {
  const auto report = [&](double balance, bool has_account = true) {
    scene.exchange.now += 1ms;
    scene.exchange.report = HandReport{.has_account = has_account, .balance = balance};
    scene.exchange.send(kB, test::hand(scene.exchange.index[kB] + 1), false);
    scene.exchange.report.reset();
    take();
    flight.write_if_due(false, scene.exchange.now + FlightRecorder::kTogether);
  };
  report(0.0);
  report(-1.0, false);
  EXPECT_THAT(files_in(folder), IsEmpty());
  report(-0.5 * kSmallDebt);
  EXPECT_THAT(files_in(folder), IsEmpty());
  report(-2.0 * kSmallDebt);
  ASSERT_THAT(files_in(folder), SizeIs(1));
  EXPECT_EQ(read(files_in(folder).front()).reason,
            "hand 2: its client says that the account is overdrawn");
  report(-1e-3);
  report(1.0);
  report(-1.0);
  EXPECT_THAT(files_in(folder), SizeIs(1));
  report(1.0);
  run(10'000);
  report(-1.0);
  EXPECT_THAT(files_in(folder), SizeIs(2));
}

/// A client that joins and vanishes repeatedly must not fill the disk.
TEST_F(FlightRecorderTest, FaultsThatFollowEachOtherWaitForTheirFile) {
  const auto written = [&](auto after) {
    return flight.write_if_due(false, scene.exchange.now + after).has_value();
  };
  scene.exchange.sessions.evict(kA);
  take();
  EXPECT_TRUE(written(200ms));
  run(1000);
  scene.exchange.sessions.evict(kB);
  take();
  EXPECT_FALSE(written(3999ms));
  EXPECT_TRUE(written(4000ms));
  const auto files = files_in(folder);
  ASSERT_THAT(files, SizeIs(2));
  EXPECT_EQ(read(files[1]).reason, "hand 2: it was evicted");
}

TEST_F(FlightRecorderTest, ChangesAreInIt) {
  scene.exchange.sessions.change(MaterialChange{.object = "desk", .stiffness = 123.0},
                                 scene.exchange.now);
  take();
  const auto file = flight.write_if_due(true, scene.exchange.now);
  ASSERT_TRUE(file.has_value());
  EXPECT_EQ(read(*file).events.back().kind, static_cast<std::uint64_t>(EventKind::change));
}

TEST_F(FlightRecorderTest, GoodbyeIsNoFault) {
  scene.exchange.sessions.answer(control::LeaveRequest{kA}, 0, {}, scene.exchange.now);
  take();
  flight.write_if_due(false, scene.exchange.now + 10s);
  EXPECT_THAT(files_in(folder), IsEmpty());
}

/// Writing a file must keep the stored seconds.
TEST_F(FlightRecorderTest, WhoAsksGetsAFileEachTime) {
  flight.write_if_due(true, scene.exchange.now);
  run(100);
  flight.write_if_due(true, scene.exchange.now);
  const auto files = files_in(folder);
  ASSERT_THAT(files, SizeIs(2));
  EXPECT_EQ(read(files[0]).reason, "asked for");
  EXPECT_EQ(read(files[0]).events.size(), read(files[1]).events.size());
  EXPECT_EQ(read(files[1]).events.back().time,
            static_cast<std::uint64_t>(scene.exchange.now.count()));
}

TEST_F(FlightRecorderTest, OldestFilesAreRemovedAndOthersStay) {
  std::ofstream(folder / "flight-20200101T000000.000Z-other.mcap") << "another scene's";
  std::ofstream(folder / "notes.txt") << "mine";
  for (std::size_t n = 0; n < kMostFlightFiles + 3; ++n) {
    run(1);
    flight.write_if_due(true, scene.exchange.now);
  }
  const auto files = files_in(folder);
  EXPECT_THAT(files, SizeIs(kMostFlightFiles + 2));
  EXPECT_TRUE(std::filesystem::exists(folder / "notes.txt"));
  EXPECT_TRUE(std::filesystem::exists(folder / "flight-20200101T000000.000Z-other.mcap"));
}

TEST(FlightRecorder, FolderThatCannotBeMadeIsNamed) {
  try {
    const FlightRecorder flight("/dev/null/flights", "scene", {}, 0);
    FAIL();
  } catch (const FileError& error) {
    EXPECT_THAT(error.what(), HasSubstr("/dev/null/flights"));
    EXPECT_THAT(error.what(), HasSubstr("--flight-recorder"));
  }
}

/// A flight record contains personal data: the movement of a hand.
TEST_F(FlightRecorderTest, OnlyItsOwnerReadsIt) {
  run(20);
  const auto file = flight.write_if_due(true, scene.exchange.now);
  ASSERT_TRUE(file);
  EXPECT_EQ(std::filesystem::status(*file).permissions(),
            std::filesystem::perms::owner_read | std::filesystem::perms::owner_write);

  for (const unsigned mode : {0755u, 0750u, 0711u, 01777u}) {
    const std::filesystem::path open = scene.folder / ("open" + std::to_string(mode));
    std::filesystem::create_directory(open);
    std::filesystem::permissions(open, std::filesystem::perms(mode));
    try {
      FlightRecorder other(open, "scene", {}, 0);
      ADD_FAILURE() << "took a folder of mode " << mode;
    } catch (const FileError& error) {
      EXPECT_THAT(error.what(), HasSubstr("is open to others than its owner"));
      EXPECT_THAT(error.what(), HasSubstr("chmod 700 " + open.string()));
      EXPECT_THAT(error.what(), HasSubstr("--flight-recorder"));
    }
  }
}

}  // namespace
}  // namespace feltwire::flight_recorder_test

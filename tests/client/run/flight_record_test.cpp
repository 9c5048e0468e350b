// A flight record has the last seconds of ticks. The client writes it after an error.

#include "client/run/flight_record.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <csignal>
#include <cstdio>
#include <fstream>

#include "client/run/records.hpp"
#include "client/run/supervise_session.hpp"
#include "core/base/file_error.hpp"
#include "core/recording/flight_files.hpp"
#include "core/recording/mcap_reader.hpp"
#include "core/recording/sample_messages.hpp"
#include "protocol/net/clock.hpp"
#include "tests/client/temporary_folder.hpp"
#include "tests/core/recording/recordings.hpp"

namespace feltwire::flight_record_test {
namespace {

using test::files_in;
using ::testing::IsEmpty;
using ::testing::SizeIs;

constexpr double kPeriod = 1e-3;  // [s]

TickRecord tick(int n, std::optional<double> balance = std::nullopt) {
  TickRecord row;
  row.time = kPeriod * n;
  row.clock = 1'000'000LL * n;
  row.position.x() = n;
  row.balance = balance;
  return row;
}

void push(Records& records, const TickRecord& row) {
  if (Ring<TickRecord>* rows = records.rows()) rows->push(row);
}

struct Read {
  std::map<std::string, std::string> about;
  std::vector<std::map<std::string, std::string>> changes;
  std::vector<double> times;  // [s] times of the samples
};
Read read(const std::filesystem::path& file) {
  std::ifstream in(file, std::ios::binary);
  mcap::Reader reader(in, file.string());
  Read result;
  while (const auto message = reader.next())
    if (reader.channels().at(message->channel).topic == "/hand/sample")
      result.times.push_back(read_sample(message->data)->time);
  result.about = reader.metadata().front().values;
  for (const mcap::Metadata& metadata : reader.metadata())
    if (metadata.name == "change") result.changes.push_back(metadata.values);
  return result;
}

class FlightRecordTest : public ::testing::Test {
 protected:
  void TearDown() override {
    if (std::filesystem::exists(target.folder)) test::keep_recordings("client", target.folder);
  }
  testing::TemporaryFolder folder;
  FlightTarget target{folder / "flights", {{"scene", "plane"}}};
};

TEST_F(FlightRecordTest, HasTheLastTenSecondsInTheirOrder) {
  FlightRecord flight(target, kPeriod);
  EXPECT_FALSE(flight.write("nothing has come").has_value());
  for (int n = 0; n < 12'345; ++n) flight.add(tick(n));
  const auto file = flight.write("the server has fallen silent");
  ASSERT_TRUE(file.has_value());
  const Read seen = read(*file);
  EXPECT_EQ(seen.about.at("reason"), "the server has fallen silent");
  EXPECT_EQ(seen.about.at("scene"), "plane");
  ASSERT_THAT(seen.times, SizeIs(10'000));
  EXPECT_DOUBLE_EQ(seen.times.front(), kPeriod * 2345);
  EXPECT_DOUBLE_EQ(seen.times.back(), kPeriod * 12'344);
  EXPECT_TRUE(std::ranges::is_sorted(seen.times));
}

/// A lasting debt counts once. Further debts within ten seconds of a file do not count.
TEST_F(FlightRecordTest, OverdrawnAccountIsADebtOnce) {
  FlightRecord flight(target, kPeriod);
  flight.add(tick(0));
  flight.add(tick(1, 0.0));
  flight.add(tick(2, -0.5 * kSmallDebt));  // too small to feel
  EXPECT_EQ(flight.cause(), "");
  flight.add(tick(3, -2.0 * kSmallDebt));
  EXPECT_EQ(flight.cause(), "the account was overdrawn");
  flight.write("debt");
  for (int n = 4; n < 9000; ++n) flight.add(tick(n, n % 2 == 0 ? -1.0 : 1.0));
  EXPECT_EQ(flight.cause(), "");
  flight.add(tick(10'003, 1.0));
  flight.add(tick(10'004, -1.0));
  EXPECT_EQ(flight.cause(), "the account was overdrawn");
}

/// Each cause has its own ten seconds. A file for one cause must not suppress another cause.
TEST_F(FlightRecordTest, LostSessionAndDeviceFaultAreCauses) {
  FlightRecord flight(target, kPeriod);
  const auto add = [&](int n, ZeroForceReason reason) {
    TickRecord row = tick(n);
    row.no_force = reason;
    flight.add(row);
  };
  add(0, ZeroForceReason::touches_nothing);
  add(1, ZeroForceReason::silent);
  EXPECT_EQ(flight.cause(), "");
  add(2, ZeroForceReason::reconnecting);
  add(3, ZeroForceReason::reconnecting);
  EXPECT_EQ(flight.cause(), "a lost session goes on");
  flight.write(flight.cause());
  EXPECT_EQ(flight.cause(), "");
  add(4, ZeroForceReason::device_fault);
  EXPECT_EQ(flight.cause(), "the device had a fault");
  flight.write(flight.cause());
  add(5, ZeroForceReason::felt);
  add(6, ZeroForceReason::reconnecting);
  add(7, ZeroForceReason::device_fault);
  EXPECT_EQ(flight.cause(), "");
  add(8, ZeroForceReason::felt);
  add(10'003, ZeroForceReason::reconnecting);
  add(10'005, ZeroForceReason::device_fault);
  EXPECT_EQ(flight.cause(), "a lost session goes on; the device had a fault");
}

TEST_F(FlightRecordTest, HasTheChangesOfItsTime) {
  FlightRecord flight(target, kPeriod);
  const std::int64_t now = monotonic_now().count();
  TickRecord row;
  row.clock = now + 1'000'000'000'000;  // later than the first change
  flight.note({{"what", "mode shaped -> none"}});
  flight.add(row);
  EXPECT_THAT(read(*flight.write("asked for")).changes, IsEmpty());
  row.clock = now;
  FlightRecord later(target, kPeriod);
  later.add(row);
  later.note({{"what", "mode shaped -> none"}, {"answer", "taken"}});
  const auto changes = read(*later.write("asked for")).changes;
  ASSERT_THAT(changes, SizeIs(1));
  EXPECT_EQ(changes[0].at("what"), "mode shaped -> none");
  EXPECT_GE(std::stoll(changes[0].at("time")), now + clock_offset() - 1'000'000'000);
}

/// A missing default folder causes a warning. A missing folder from the user is an error.
TEST_F(FlightRecordTest, FolderThatNobodyNamedMayBeMissing) {
  target.folder = "/dev/null/flights";
  EXPECT_THROW(Records({.flight = target, .servo_period = kPeriod}), FileError);
  target.required = false;
  std::FILE* said = std::tmpfile();
  Records records({.flight = target, .servo_period = kPeriod}, said);
  EXPECT_EQ(records.rows(), nullptr);
  EXPECT_EQ(records.write_flight_record("asked for"), std::nullopt);
  EXPECT_GT(std::ftell(said), 0);
  std::fclose(said);
}

TEST_F(FlightRecordTest, FolderIsForItsUserAlone) {
  const FlightRecord flight(target, kPeriod);
  EXPECT_EQ(std::filesystem::status(target.folder).permissions(),
            std::filesystem::perms::owner_all);
}

/// The signal must write a file without an end of the program.
TEST_F(FlightRecordTest, ASignalAsksForIt) {
  std::FILE* said = std::tmpfile();
  Records records({.flight = target, .servo_period = kPeriod}, said);
  const Signals signals(true);
  EXPECT_FALSE(signals.take().record);
  ASSERT_EQ(::raise(SIGUSR1), 0);
  const Signals::PendingSignals came = signals.take();
  EXPECT_TRUE(came.record);
  EXPECT_FALSE(came.end);
  ASSERT_EQ(::raise(SIGTERM), 0);
  EXPECT_TRUE(signals.take().end);
  EXPECT_FALSE(signals.take().record);
  push(records, tick(0, 1.0));
  records.write();
  records.tell_of_flight_record("asked for");
  ASSERT_THAT(files_in(target.folder), SizeIs(1));
  EXPECT_EQ(read(files_in(target.folder).front()).about.at("reason"), "asked for");
  ASSERT_THAT(records.flight_records(), SizeIs(1));
  EXPECT_EQ(records.flight_records()[0].file, files_in(target.folder).front());
  EXPECT_EQ(records.flight_records()[0].cause, "asked for");
  EXPECT_GT(std::ftell(said), 0);
  std::fclose(said);
}

TEST_F(FlightRecordTest, RecordsWriteADebtAndAnError) {
  std::FILE* said = std::tmpfile();
  Records records({.flight = target, .servo_period = kPeriod}, said);
  for (int n = 0; n < 100; ++n) push(records, tick(n, 1.0));
  records.write();
  EXPECT_THAT(files_in(target.folder), IsEmpty());
  push(records, tick(100, -1.0));
  records.write();
  ASSERT_THAT(files_in(target.folder), SizeIs(1));
  EXPECT_THAT(read(files_in(target.folder).front()).times, SizeIs(101));
  push(records, tick(200, 1.0));
  records.finish();
  const auto file = records.write_flight_record("the servo loop broke off");
  ASSERT_TRUE(file.has_value());
  EXPECT_THAT(read(*file).times, SizeIs(102));
  EXPECT_FALSE(records.failed());
  EXPECT_GT(std::ftell(said), 0);
  std::fclose(said);
}

/// Both files must have each tick.
TEST_F(FlightRecordTest, RecordingGoesOnBesideIt) {
  const auto recording = folder / "hand.mcap";
  Records records(
      {.recording = RecordingTarget{.file = recording}, .flight = target, .servo_period = kPeriod});
  for (int n = 0; n < 500; ++n) {
    push(records, tick(n));
    if (n % 50 == 0) records.write();
  }
  records.finish();
  EXPECT_THAT(read(recording).times, SizeIs(500));
  EXPECT_THAT(read(*records.write_flight_record("asked")).times, SizeIs(500));
}

TEST_F(FlightRecordTest, OldestFilesAreRemoved) {
  FlightRecord flight(target, kPeriod);
  for (int n = 0; n < static_cast<int>(kMostFlightFiles) + 5; ++n) {
    flight.add(tick(n));
    flight.write("asked");
  }
  EXPECT_THAT(files_in(target.folder), SizeIs(kMostFlightFiles));
}

TEST_F(FlightRecordTest, OldestFilesAreRemovedWhereTheyAreLarge) {
  FlightRecord flight(target, kPeriod);
  flight.add(tick(0));
  std::vector<std::filesystem::path> files;
  for (int n = 0; n < 3; ++n) {
    files.push_back(*flight.write("asked"));
    std::filesystem::resize_file(files.back(), kMostFlightBytes / 2);
  }
  files.push_back(*flight.write("asked"));
  EXPECT_THAT(files_in(target.folder),
              ::testing::UnorderedElementsAre(files[1], files[2], files[3]));
}

}  // namespace
}  // namespace feltwire::flight_record_test

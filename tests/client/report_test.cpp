#include "client/report.hpp"

#include <fcntl.h>
#include <gmock/gmock.h>
#include <sys/stat.h>
#include <unistd.h>

#include <memory>
#include <nlohmann/json.hpp>

#include "tests/client/temporary_folder.hpp"

namespace feltwire {
namespace {

using nlohmann::json;
using testing::error_of;
using ::testing::HasSubstr;
using testing::TemporaryFolder;
using testing::text_of;

/// A servo that has made three samples, of which two were answered.
std::unique_ptr<Servo> used_servo() {
  SessionParameters p;
  p.mode = BoundingMode::none;
  auto servo = std::make_unique<Servo>(builtin_device("simulated"), p);
  Nanoseconds now{0};
  for (std::uint64_t i = 1; i <= 3; ++i) {
    now += std::chrono::milliseconds(1);
    servo->render({.pose = {.position = Vec3(0, 0, 0.01 * static_cast<double>(i))}}, now);
    servo->hold({.elastic = Vec3(0, 0, 2)});
    Reply reply;
    reply.sample_index = i;
    reply.command.elastic = Vec3(0, 0, 2);
    reply.violations = 7;
    reply.delivered.elastic = 0.5;
    if (i != 2)
      servo->take(reply, now + std::chrono::microseconds(100 * i * i * i));  // 100 us and 2.7 ms
  }
  return servo;
}

json report(const Servo& servo, const LoopResult& result = {}, const std::string& client = "anna") {
  TransportStatistics transport;
  transport.sent = 6;
  transport.dropped[static_cast<std::size_t>(DropReason::malformed)] = 4;
  return json::parse(
      report_json({client, "wall", "localhost:7400", "simulated", {}}, servo, transport, result));
}

TEST(Report, HoldsWhatWasCounted) {
  const auto servo = used_servo();
  LoopResult result;
  result.end = EndReason::requested;
  result.duration = 0.003;
  result.overruns = 1;
  for (int i = 1; i <= 100; ++i) result.wakeup_late.record(i * 1000);
  const json r = report(*servo, result);
  EXPECT_EQ(r["client"], "anna");
  EXPECT_EQ(r["scene"], "wall");
  EXPECT_EQ(r["device"]["kind"], "simulated");
  EXPECT_EQ(r["end"], "requested");
  EXPECT_EQ(r["duration_s"], 0.003);
  EXPECT_EQ(r["samples"], 3);
  EXPECT_EQ(r["answered"], 2);
  EXPECT_EQ(r["lost"], 1);
  EXPECT_EQ(r["late"], 1);
  EXPECT_NEAR(r["round_trip_us"]["p50"].get<double>(), 100.0, 0.5);
  EXPECT_EQ(r["round_trip_us"]["max"], 2700.0);
  EXPECT_NEAR(r["energy_delivered_j"]["elastic"].get<double>(), 0.04, 1e-12);
  EXPECT_EQ(r["energy_delivered_j"]["torque"], 0.0);
  EXPECT_EQ(r["bound_violations"], servo->port().violations());
  EXPECT_EQ(r["max_force_n"], 2.0);
  EXPECT_EQ(r["direction_error_deg"]["mean"], 0.0);
  EXPECT_NEAR(r["servo_wakeup_late_us"]["p99"].get<double>(), 99.0, 0.4);
  EXPECT_EQ(r["overruns"], 1);
  EXPECT_EQ(r["dropped"]["malformed"], 4);
  EXPECT_EQ(r["parameters"]["mode"], "none");
  EXPECT_EQ(r["parameters"]["side"], "both");
  EXPECT_EQ(r["server_last_reply"]["bound_violations"], 7);
  EXPECT_EQ(r["server_last_reply"]["energy_delivered_j"]["elastic"], 0.5);
}

TEST(Report, WhatThereIsNoNumberForIsNull) {
  const Servo idle(builtin_device("simulated"), {});
  const json r = report(idle);
  EXPECT_TRUE(r["round_trip_us"]["p50"].is_null());
  EXPECT_TRUE(r["direction_error_deg"]["p99"].is_null());
  EXPECT_TRUE(r["server_last_reply"].is_null());
  EXPECT_EQ(r["samples"], 0);
}

TEST(Report, StaysJsonWhateverItIsTold) {
  const auto servo = used_servo();
  LoopResult result;
  result.duration = std::numeric_limits<double>::infinity();
  const json r = report(*servo, result, "a\"b\\c\n\xff\xfe");
  EXPECT_TRUE(r["duration_s"].is_null());
  EXPECT_THAT(r["client"].get<std::string>(), HasSubstr("a\"b\\c\n"));
}

TEST(WriteWhole, ReplacesInOneStepAndLeavesNothingBeside) {
  const TemporaryFolder folder;
  const auto file = folder / "report.json";
  write_whole(file, "old");
  struct stat before, after;
  ASSERT_EQ(::stat(file.c_str(), &before), 0);
  std::ifstream reader(file);  // opened before: keeps seeing all of the old text
  write_whole(file, "new and longer");
  ASSERT_EQ(::stat(file.c_str(), &after), 0);
  EXPECT_NE(before.st_ino, after.st_ino);
  EXPECT_EQ(std::string(std::istreambuf_iterator<char>(reader), {}), "old");
  EXPECT_EQ(text_of(file), "new and longer");
  EXPECT_EQ(folder.entries(), 1u);
}

TEST(WriteWhole, FollowsLinks) {
  const TemporaryFolder folder;
  write_whole(folder / "real.json", "old");
  std::filesystem::create_symlink(folder / "real.json", folder / "link.json");
  write_whole(folder / "link.json", "new");
  EXPECT_EQ(text_of(folder / "real.json"), "new");
  EXPECT_TRUE(std::filesystem::is_symlink(folder / "link.json"));
}

TEST(WriteWhole, WritesIntoWhatIsNoRegularFile) {
  const TemporaryFolder folder;
  const auto pipe = folder / "pipe";
  ASSERT_EQ(::mkfifo(pipe.c_str(), 0600), 0);
  const int reader = ::open(pipe.c_str(), O_RDONLY | O_NONBLOCK);
  ASSERT_GE(reader, 0);
  check_writable(pipe);
  write_whole(pipe, "text");
  char buffer[16];
  EXPECT_EQ(::read(reader, buffer, sizeof buffer), 4);
  ::close(reader);
  EXPECT_TRUE(std::filesystem::is_fifo(pipe));
}

TEST(CheckWritable, TellsBeforeTheRunAndTouchesNothing) {
  const TemporaryFolder folder;
  EXPECT_THAT(error_of<std::runtime_error>([&] { check_writable(folder / "no/such/report.json"); }),
              HasSubstr("no/such/report.json: No such file or directory"));
  EXPECT_THAT(error_of<std::runtime_error>([&] { check_writable(folder / "."); }),
              HasSubstr("directory"));
  write_whole(folder / "there.json", "kept");
  check_writable(folder / "there.json");
  check_writable(folder / "new.json");
  EXPECT_EQ(text_of(folder / "there.json"), "kept");
  EXPECT_EQ(folder.entries(), 1u);
}

}  // namespace
}  // namespace feltwire

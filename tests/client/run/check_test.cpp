// Tests the verdict of --check for measured figures. docs/troubleshooting.md has the limits.

#include "client/run/check.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <nlohmann/json.hpp>

namespace feltwire::check_test {
namespace {

using ::testing::HasSubstr;
constexpr std::int64_t kMillisecond = 1'000'000;  // [ns]

/// Returns the figures of ten seconds at 1 kHz on a good machine and network.
RunFigures good_run() {
  RunFigures run;
  run.end = EndReason::duration;
  run.duration = 10.0;
  run.servo_period = 1e-3;
  run.hold_time = 0.1;
  run.samples = run.datagrams = 10'000;
  run.jitter = 1e-4;
  run.real_time = {.scheduler = true, .memory_locked = true};
  for (int i = 0; i < 10'000; ++i) {
    run.wakeup_late.record(20'000);
    run.round_trip.record(kMillisecond);
  }
  return run;
}

MachineFacts good_machine() {
  return {.clock_source = "tsc", .clock_resolution = 1e-9, .wake_latency = 0, .path_mtu = 1500};
}

/// Returns the result with this name.
CheckResult of(std::string_view what, const RunFigures& run,
               const MachineFacts& machine = good_machine()) {
  for (const CheckResult& result : judge(run, machine))
    if (result.what == what) return result;
  ADD_FAILURE() << "nothing is said of " << what;
  return {};
}

/// Returns a histogram of 10 000 values: `slow_ones` values are `slow`, and the others are `fast`.
Histogram with_slow(int slow_ones, std::int64_t slow, std::int64_t fast = 1000) {
  Histogram histogram;
  for (int i = 0; i < 10'000; ++i) histogram.record(i < slow_ones ? slow : fast);
  return histogram;
}

TEST(Check, AGoodRunPasses) {
  const auto results = judge(good_run(), good_machine());
  EXPECT_EQ(results.size(), 11u);
  for (const CheckResult& result : results) {
    EXPECT_EQ(result.verdict, Verdict::pass) << result.what << ": " << result.figure;
    EXPECT_EQ(result.remedy, "") << result.what;
  }
  EXPECT_EQ(worst(results), Verdict::pass);
}

TEST(Check, Rate) {
  RunFigures run = good_run();
  const auto of_missing = [&](std::uint64_t missed) {
    run.missed_deadlines = missed;
    run.samples = 10'000 - missed;
    return of("rate", run).verdict;
  };
  EXPECT_EQ(of_missing(10), Verdict::pass);
  EXPECT_EQ(of_missing(11), Verdict::warn);
  EXPECT_EQ(of_missing(500), Verdict::warn);
  EXPECT_EQ(of_missing(501), Verdict::fail);
  EXPECT_THAT(of("rate", run).figure, HasSubstr("949.9 of 1000 ticks"));
  run.samples = run.missed_deadlines = 0;
  EXPECT_EQ(of("rate", run).verdict, Verdict::fail) << "no tick at all";
}

TEST(Check, LateWakeUps) {
  RunFigures run = good_run();
  const auto of_late = [&](int late_ones, std::int64_t late) {
    run.wakeup_late = with_slow(late_ones, late);
    return of("late wake-ups", run).verdict;
  };
  EXPECT_EQ(of_late(100, kMillisecond), Verdict::pass) << "one in a hundred";
  EXPECT_EQ(of_late(101, 99'000), Verdict::pass);
  EXPECT_EQ(of_late(101, 110'000), Verdict::warn);
  EXPECT_EQ(of_late(101, 490'000), Verdict::warn);
  EXPECT_EQ(of_late(101, 510'000), Verdict::fail);
  run.servo_period = 1e-2;
  EXPECT_EQ(of_late(101, 510'000), Verdict::pass) << "of a slower servo";
}

TEST(Check, Permissions) {
  RunFigures run = good_run();
  run.real_time.scheduler = false;
  const CheckResult less = of("permissions", run);
  EXPECT_EQ(less.verdict, Verdict::warn);
  EXPECT_THAT(less.remedy, HasSubstr("CAP_SYS_NICE"));
  run.real_time = {.scheduler = true, .memory_locked = false};
  EXPECT_EQ(of("permissions", run).verdict, Verdict::warn);
}

/// Processor sleep states cause a warning only if ticks are late.
TEST(Check, ProcessorsThatSleep) {
  RunFigures run = good_run();
  MachineFacts machine = good_machine();
  machine.wake_latency = 2'000'000'000;
  EXPECT_EQ(of("processors", run, machine).verdict, Verdict::pass);
  run.wakeup_late = with_slow(5000, 200'000);
  EXPECT_EQ(of("processors", run, machine).verdict, Verdict::warn);
  EXPECT_EQ(of("processors", run).verdict, Verdict::pass) << "they do not sleep";
  machine.wake_latency = std::nullopt;
  EXPECT_EQ(of("processors", run, machine).verdict, Verdict::warn);
}

TEST(Check, Clock) {
  MachineFacts machine = good_machine();
  machine.clock_source = "hpet";
  EXPECT_EQ(of("clock", good_run(), machine).verdict, Verdict::warn);
  machine.clock_resolution = 4e-3;  // [s] The kernel has no high-resolution timers.
  EXPECT_EQ(of("clock", good_run(), machine).verdict, Verdict::fail);
  machine = good_machine();
  machine.clock_source.clear();
  EXPECT_EQ(of("clock", good_run(), machine).verdict, Verdict::pass);
}

TEST(Check, RoundTrip) {
  RunFigures run = good_run();
  const auto of_slow = [&](std::int64_t milliseconds) {
    run.round_trip = with_slow(200, milliseconds * kMillisecond);
    return of("round trip", run).verdict;
  };
  EXPECT_EQ(of_slow(24), Verdict::pass);
  EXPECT_EQ(of_slow(26), Verdict::warn);
  EXPECT_EQ(of_slow(49), Verdict::warn);
  EXPECT_EQ(of_slow(51), Verdict::fail) << "such a command fades";
}

TEST(Check, Jitter) {
  RunFigures run = good_run();
  const auto of_jitter = [&](double seconds) {
    run.jitter = seconds;
    return of("jitter", run).verdict;
  };
  EXPECT_EQ(of_jitter(3e-3), Verdict::pass);
  EXPECT_EQ(of_jitter(4e-3), Verdict::warn);
  EXPECT_EQ(of_jitter(13e-3), Verdict::fail);
}

TEST(Check, Loss) {
  RunFigures run = good_run();
  const auto of_lost = [&](std::uint64_t lost) {
    run.lost = lost;
    return of("loss", run).verdict;
  };
  EXPECT_EQ(of_lost(10), Verdict::pass);
  EXPECT_EQ(of_lost(11), Verdict::warn);
  EXPECT_EQ(of_lost(501), Verdict::fail);
}

TEST(Check, DatagramSize) {
  MachineFacts machine = good_machine();
  machine.path_mtu = 1228;
  EXPECT_EQ(of("datagram size", good_run(), machine).verdict, Verdict::pass);
  machine.ipv6 = true;
  EXPECT_EQ(of("datagram size", good_run(), machine).verdict, Verdict::warn);
  EXPECT_THAT(of("datagram size", good_run(), machine).remedy, HasSubstr("1248"));
  machine.path_mtu = std::nullopt;
  EXPECT_EQ(of("datagram size", good_run(), machine).verdict, Verdict::warn);
  RunFigures run = good_run();
  run.too_long = 1;
  EXPECT_EQ(of("datagram size", run).verdict, Verdict::fail);
}

TEST(Check, ASessionThatEndedOrWasNeverAnswered) {
  RunFigures run = good_run();
  run.end = EndReason::server_silent;
  EXPECT_EQ(of("session", run).verdict, Verdict::fail);
  run = good_run();
  run.round_trip = {};
  EXPECT_EQ(of("answers", run).verdict, Verdict::fail);
  for (const CheckResult& result : judge(run, good_machine()))
    EXPECT_NE(result.what, "loss") << "of what was never answered nothing is known";
}

TEST(Check, IsSaidInATableAndInJson) {
  const std::vector<CheckResult> results = {{"rate", Verdict::pass, "1000 of 1000", ""},
                                            {"loss", Verdict::fail, "9 %", "a \"cable\""}};
  EXPECT_EQ(worst(results), Verdict::fail);
  EXPECT_EQ(table(results),
            "pass  rate            1000 of 1000\nfail  loss            9 %\n"
            "      remedy: a \"cable\"\n");
  const auto list = nlohmann::json::parse(json(results));
  EXPECT_EQ(list[1]["verdict"], "fail");
  EXPECT_EQ(list[1]["remedy"], "a \"cable\"");
}

}  // namespace
}  // namespace feltwire::check_test

// Tests log lines about moving bodies, and their rate on a simulated clock.

#include "server/scene/world_log.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

namespace feltwire::world_log_test {
namespace {

using namespace std::chrono_literals;
using ::testing::ElementsAre;
using ::testing::HasSubstr;
using ::testing::SizeIs;

constexpr double kTick = 1e-3;

TEST(WorldLog, ASceneThatIsNeverSaneSaysSoOnceASecond) {
  WorldLog log;
  WorldNews news{.tick = kTick};
  std::vector<std::string> all;
  Nanoseconds now{5s};
  const auto step = [&] {
    now += 1ms;
    ++news.counters.steps;
    for (auto& line : log.lines(news, now)) all.push_back(std::move(line));
  };
  for (int n = 0; n < 10'000; ++n) {
    ++news.counters.resets;
    step();
  }
  ASSERT_THAT(all, SizeIs(10));
  EXPECT_THAT(all[0], HasSubstr("(1 times since the last line, 1 times so far)"));
  EXPECT_THAT(all[1], HasSubstr("(1000 times since the last line, 1001 times so far)"));
  // A single line at the end must summarize the omitted lines.
  for (int n = 0; n < 3000; ++n) step();
  ASSERT_THAT(all, SizeIs(11));
  EXPECT_THAT(all[10], HasSubstr("10000 times so far"));
}

TEST(WorldLog, TicksThatAreDroppedAndWarningsAreToldAtMostOnceASecondWhenThereAreTwiceAsMany) {
  WorldLog log;
  WorldNews news{.tick = kTick};
  std::vector<std::uint64_t> dropped, warned;  // times of lines
  Nanoseconds now{5s};
  for (std::uint64_t n = 1; n <= 100'000; ++n) {
    now += 1ms;
    news.ticks_dropped = news.counters.warnings = n;
    for (const auto& line : log.lines(news, now))
      (line.find("dropped") != std::string::npos ? dropped : warned).push_back(n);
  }
  EXPECT_THAT(dropped, ElementsAre(1, 1001, 2002, 4004, 8008, 16016, 32032, 64064));
  EXPECT_EQ(warned, dropped);
}

TEST(WorldLog, AnotherWorldIsToldOfFromTheBeginning) {
  WorldLog log;
  WorldNews news{.counters = {.resets = 7, .warnings = 900}, .tick = kTick};
  EXPECT_THAT(log.lines(news, 1s), SizeIs(2));
  log.begin_anew();
  news.counters = {.resets = 1, .warnings = 1};
  EXPECT_THAT(log.lines(news, 3s), SizeIs(2));
  EXPECT_THAT(log.lines(news, 5s), SizeIs(0));
}

}  // namespace
}  // namespace feltwire::world_log_test

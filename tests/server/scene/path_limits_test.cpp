// The longest replies that the paths to clients take.

#include "server/scene/path_limits.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "tests/server/make_slot.hpp"

namespace feltwire::path_limits_test {
namespace {

using namespace std::chrono_literals;
using ::testing::HasSubstr;

TEST(PathLimits, HoldForAMinute) {
  const Scene scene = test::room();
  const auto slot = test::make_slot(scene, 1);
  SceneLog log;
  PathLimits paths(log);
  EXPECT_EQ(paths.room(*slot, 0s), kMaxPayload);
  paths.limit(*slot, 500, 1s);
  EXPECT_EQ(paths.room(*slot, 60s), 500u);
  EXPECT_EQ(paths.room(*slot, 61s), kMaxPayload) << "longer replies are tried again";
  paths.limit(*slot, 10 * kMaxPayload, 62s);
  EXPECT_EQ(paths.room(*slot, 62s), kMaxPayload);
}

TEST(PathLimits, EachSessionIsReportedOnce) {
  const Scene scene = test::room();
  SessionSlots slots;
  slots.push_back(test::make_slot(scene, 1));
  slots.push_back(test::make_slot(scene, 2));
  SceneLog log;
  PathLimits paths(log);
  EXPECT_FALSE(paths.has_short_paths());
  paths.limit(*slots[1], 500, 1s);
  EXPECT_TRUE(paths.has_short_paths());
  const std::vector<std::string> lines = paths.short_paths(slots);
  ASSERT_EQ(lines.size(), 1u);
  EXPECT_THAT(lines[0], HasSubstr("session 2 (tester)"));
  EXPECT_THAT(lines[0], HasSubstr("no datagrams above " + std::to_string(500 + kOverhead)));
  paths.limit(*slots[1], 400, 2s);
  EXPECT_FALSE(paths.has_short_paths());
  EXPECT_TRUE(paths.short_paths(slots).empty());
}

TEST(PathLimits, AreInTheLog) {
  const Scene scene = test::room();
  const auto slot = test::make_slot(scene, 3);
  EventLog events(std::size_t{1} << 12);
  SceneLog log;
  log.log_to(&events);
  PathLimits paths(log);
  paths.limit(*slot, 0x234, 1s);
  const auto event = events.take();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, EventKind::path);
  EXPECT_EQ(event->hand, 3u);
  ASSERT_EQ(event->payload.size(), 2u);
  EXPECT_EQ(event->payload[0] | event->payload[1] << 8, 0x234);
}

}  // namespace
}  // namespace feltwire::path_limits_test

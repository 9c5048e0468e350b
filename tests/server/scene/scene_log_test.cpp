// The events of a scene on their way into its log.

#include "server/scene/scene_log.hpp"

#include <gtest/gtest.h>

#include <optional>

#include "tests/core/moving.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::scene_log_test {
namespace {

using namespace std::chrono_literals;

constexpr std::size_t kRoom = std::size_t{1} << 14;  // [bytes] of the log

TEST(SceneLog, DoesNothingWithoutALog) {
  SceneLog log;
  EXPECT_FALSE(log.is_on());
  log.put({.kind = EventKind::tick, .time = 1ms});
  log.put_end(1, SessionEnd::silent);
  log.check(nullptr, 2ms);
  log.announce(nullptr);
  EXPECT_TRUE(log.payload(control::LeaveRequest{7}).empty());
}

TEST(SceneLog, NumbersTheEventsInTheirOrder) {
  EventLog events(kRoom);
  SceneLog log;
  log.log_to(&events);
  log.put({.kind = EventKind::tick, .time = 1ms});
  log.put({.kind = EventKind::reload, .time = 2ms});
  std::optional<SceneEvent> event = events.take();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, EventKind::tick);
  EXPECT_EQ(event->number, 1u);
  event = events.take();
  ASSERT_TRUE(event);
  EXPECT_EQ(event->kind, EventKind::reload);
  EXPECT_EQ(event->number, 2u);
  EXPECT_FALSE(events.take());
}

/// A session may end where no time is known.
TEST(SceneLog, AnEndHasTheTimeOfTheNewestEvent) {
  EventLog events(kRoom);
  SceneLog log;
  log.log_to(&events);
  log.put({.kind = EventKind::tick, .time = 5ms});
  log.put_end(3, SessionEnd::flooded);
  events.take();
  const std::optional<SceneEvent> end = events.take();
  ASSERT_TRUE(end);
  EXPECT_EQ(end->kind, EventKind::end);
  EXPECT_EQ(end->hand, 3u);
  EXPECT_EQ(end->time, Nanoseconds(5ms));
  ASSERT_EQ(end->payload.size(), 1u);
  EXPECT_EQ(static_cast<SessionEnd>(end->payload[0]), SessionEnd::flooded);
}

TEST(SceneLog, ThePayloadOfAMessageIsTheBodyOfItsFrame) {
  EventLog events(kRoom);
  SceneLog log;
  log.log_to(&events);
  const control::Message message = control::LeaveRequest{7};
  const std::vector<std::uint8_t> frame = control::encode(message);
  EXPECT_EQ(log.payload(message),
            std::vector<std::uint8_t>(frame.begin() + control::kFrameLengthSize, frame.end()));
}

/// A replay whose bodies are elsewhere gives another digest.
TEST(SceneLog, ACheckTellsWhereTheBodiesAre) {
  const Scene scene = test::moving({test::object("ball", Sphere{0.01}, {}, {0, 0, 0.5})}, {0},
                                   {test::body("ball", 0.1, {0, 0, 0.5})});
  World world(scene);
  EventLog events(kRoom);
  SceneLog log;
  log.log_to(&events);
  const auto digest = [&] {
    const std::size_t before = test::allocations();
    log.check(&world, 1s);
    EXPECT_EQ(test::allocations(), before);
    const std::optional<SceneEvent> check = events.take();
    EXPECT_TRUE(check && check->kind == EventKind::check);
    return check ? check->digest : 0;
  };
  const std::uint64_t first = digest();
  EXPECT_EQ(digest(), first);
  world.step();
  EXPECT_NE(digest(), first);
}

}  // namespace
}  // namespace feltwire::scene_log_test

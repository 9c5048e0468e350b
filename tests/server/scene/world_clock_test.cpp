// The time of a scene's moving objects, with hands and without.

#include "server/scene/world_clock.hpp"

#include <gtest/gtest.h>

#include "tests/core/moving.hpp"
#include "tests/server/make_slot.hpp"
#include "tests/support/allocation_counter.hpp"

namespace feltwire::world_clock_test {
namespace {

using namespace std::chrono_literals;

/// A ball of 3 cm that floats at the origin.
Scene ball() {
  return test::moving({test::object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                      {test::body("ball", 0.1)}, test::kWeightless);
}

struct Bench {
  explicit Bench(Scene in = ball()) : scene(std::move(in)) {
    clock.run(WorldClock::world_of(scene), Nanoseconds{0});
    tick = from_seconds(clock.world()->tick());
  }
  std::uint64_t steps() const { return clock.counters().world.steps; }
  void run_to(Nanoseconds now) { clock.tick(now, hands, {}); }
  Vec3 place() const { return clock.world()->objects().back().pose.position; }

  Scene scene;
  WorldClock clock;
  SessionSlots hands;
  Nanoseconds tick{};
};

TEST(WorldClock, HasNoTicksWhereNothingMoves) {
  WorldClock clock;
  const Scene room = test::room();
  clock.run(WorldClock::world_of(room), Nanoseconds{0});
  EXPECT_EQ(clock.world(), nullptr);
  EXPECT_FALSE(clock.next_tick());
  EXPECT_FALSE(clock.is_due(1s));
  clock.tick(1s, {}, {});
  EXPECT_EQ(clock.counters().world.steps, 0u);
}

TEST(WorldClock, MakesTheTicksThatAreDue) {
  Bench bench;
  EXPECT_EQ(bench.clock.next_tick(), bench.tick);
  bench.run_to(bench.tick - 1ns);
  EXPECT_EQ(bench.steps(), 0u);
  const std::size_t before = test::allocations();
  bench.run_to(3 * bench.tick + 1ns);
  EXPECT_EQ(test::allocations(), before);
  EXPECT_EQ(bench.steps(), 3u);
  EXPECT_EQ(bench.clock.next_tick(), 4 * bench.tick);
}

TEST(WorldClock, DropsTheTimeThatItCannotMakeUpFor) {
  Bench bench;
  bench.run_to(50 * bench.tick);
  EXPECT_EQ(bench.steps(), 20u);
  EXPECT_EQ(bench.clock.ticks_dropped(), 30u);
  EXPECT_EQ(bench.clock.next_tick(), 51 * bench.tick);
  bench.run_to(100 * bench.tick);  // again: the limit is halved
  EXPECT_EQ(bench.steps(), 30u);
  EXPECT_EQ(bench.clock.ticks_dropped(), 70u);
}

TEST(WorldClock, TimeBeginsWithTheFirstSession) {
  Bench bench;
  bench.clock.begin(1s);
  bench.run_to(1s + bench.tick);
  EXPECT_EQ(bench.steps(), 1u);
  EXPECT_EQ(bench.clock.ticks_dropped(), 0u);
}

TEST(WorldClock, CountsTheStepsOfAllWorldsSoFar) {
  Bench bench;
  bench.run_to(2 * bench.tick);
  const Scene next = ball();
  EXPECT_NE(bench.clock.run(WorldClock::world_of(next), 2 * bench.tick), nullptr);
  bench.run_to(5 * bench.tick);
  EXPECT_EQ(bench.steps(), 5u);
  bench.clock.run(nullptr, 5 * bench.tick);
  EXPECT_EQ(bench.steps(), 5u);
}

TEST(WorldClock, AHandPushesUnlessItIsDisturbing) {
  for (const bool disturbing : {false, true}) {
    Bench bench;
    bench.hands.push_back(
        test::make_slot(bench.scene, 1, test::join_request({}), bench.clock.world()));
    SessionSlot& hand = *bench.hands.front();
    hand.blame.disturbing = disturbing;
    SampleBatch batch;
    batch.count = 1;
    batch.samples[0].index = 1;
    batch.samples[0].pose.position = {0.029, 0, 0};
    ASSERT_EQ(hand.session.take(batch, Nanoseconds{0}).drop, DropReason::none);
    bench.run_to(5 * bench.tick);
    if (disturbing)
      EXPECT_EQ(bench.place(), Vec3(0, 0, 0));
    else
      EXPECT_LT(bench.place().x(), 0.0);
  }
}

/// A box on a table.
Scene box() {
  const Material wood{.stiffness = 1e5, .static_friction = 0.5, .dynamic_friction = 0.4};
  return test::moving({test::object("table", Plane{}, wood),
                       test::object("box", Box{Vec3::Constant(0.02)}, wood, {0, 0, 0.02})},
                      {-1, 0}, {test::body("box", 0.05, {0, 0, 0.02})});
}

/// The place of a hand that stabs a third of a metre through the box, and returns above it.
Vec3 stab(std::uint64_t milliseconds) {
  const auto phase = milliseconds % 320;
  if (phase < 20) return {0.3, 0, 0.02};
  if (phase < 100) return {0.3, 0, 0.5};
  if (phase < 200) return {-0.025, 0, 0.5};
  return {-0.025, 0, 0.02};
}

/// Its device claims ten kilonewtons, more than any real device.
TEST(WorldClock, AHandThatBreaksTheWorldAgainAndAgainIsDisturbing) {
  Bench bench(box());
  control::JoinRequest giant = test::join_request({});
  giant.device.max_force = giant.device.continuous_force = 1e4;
  bench.hands.push_back(test::make_slot(bench.scene, 1, giant, bench.clock.world()));
  SessionSlot& hand = *bench.hands.front();
  SampleBatch batch;
  batch.count = 1;
  for (std::uint64_t n = 1; n <= 8000 && !hand.blame.disturbing; ++n) {
    const Nanoseconds now = std::chrono::milliseconds(n);
    batch.previous = n - 1;
    batch.samples[0].index = n;
    batch.samples[0].client_time = hand.last_heard = now;
    batch.samples[0].pose.position = stab(n + 200);
    ASSERT_EQ(hand.session.take(batch, now).drop, DropReason::none);
    bench.run_to(now);
  }
  EXPECT_TRUE(hand.blame.disturbing);
  EXPECT_GT(bench.clock.counters().world.resets, std::uint64_t{SessionLimits::kResets});
}

}  // namespace
}  // namespace feltwire::world_clock_test

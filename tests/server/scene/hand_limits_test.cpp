// Hands that exceed human limits act on moving objects. These hands must not disturb the other
// hands.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/moving.hpp"
#include "tests/server/moving_bench.hpp"

namespace feltwire::hand_limits_test {
namespace {

using namespace std::chrono_literals;
using test::body;
using test::box_on_table;
using test::kGrippy;
using test::kLeft;
using test::kRight;
using test::kWeightless;
using test::moving;
using test::MovingBench;
using test::object;

constexpr double kTick = kDefaultTick;

/// A hand rests on the box. At each sample, another hand jumps from a kilometre on one side to a
/// kilometre on the other side.
TEST(HandLimits, AHandThatJumpsAKilometreDisturbsNobody) {
  const Scene scene = box_on_table();
  const auto run = [&](bool disturbed) {
    MovingBench bench(scene);
    bench.join(kLeft);
    bench.join(kRight);
    std::vector<double> felt;
    for (int n = 0; n < 3000; ++n) {
      felt.push_back(bench.hand(kLeft, {0.005, 0, 0.039}).command.force().norm());
      const double side = n % 2 == 0 ? 1.0 : -1.0;
      bench.hand(kRight, {disturbed ? side * 1000.0 : 1.0, 0, 0.02});
      bench.advance();
    }
    EXPECT_EQ(bench.sessions.counters().world.resets, 0u);
    return felt;
  };
  EXPECT_EQ(run(true), run(false));
}

/// A hand must push a ball in a tick with at most its device's force, at any depth.
TEST(HandLimits, AHandPushesWithItsDevicesForceAtMost) {
  const Scene scene = moving({object("ball", Sphere{0.1}, {.stiffness = 1000})}, {0},
                             {body("ball", 2.0)}, kWeightless);
  MovingBench bench(scene);
  bench.join(kLeft);
  const double most = test::device().max_force;
  double momentum = 0.0, largest = 0.0, told = 0.0;
  for (int n = 0; n < 200; ++n) {
    const Vec3 place = bench.place(0) - Vec3(0.1 - 2.5e-4 * n, 0, 0);  // up to 5 cm deep: 50 N
    told = bench.hand(kLeft, place).command.force().norm();
    bench.advance();
    const double now = bench.world().momentum().norm();
    EXPECT_NEAR(now - momentum, kTick * std::min(most, told), 1e-12) << n;
    largest = std::max(largest, (now - momentum) / kTick);
    momentum = now;
  }
  EXPECT_NEAR(told, 49.75, 0.1);
  EXPECT_NEAR(largest, most, 1e-9);
}

/// A hand stays directly beside the ball at any speed. The hand repeatedly moves by a metre, which
/// network delay may explain. The ball then moves away.
TEST(HandLimits, AHandThatChasesABodyBreaksNothing) {
  const Scene scene = moving({object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                             {body("ball", 0.1)}, kWeightless);
  MovingBench bench(scene);
  bench.join(kLeft);
  double fastest = 0.0;
  for (int n = 0; n < 5000; ++n) {
    bench.hand(kLeft, bench.place(0) - Vec3(0.01, 0, 0));
    bench.advance();
    fastest = std::max(fastest, bench.world().momentum().norm() / 0.1);
  }
  EXPECT_EQ(bench.sessions.counters().world.resets, 0u);
  EXPECT_GT(fastest, 0.8 * kFastestHand);
  EXPECT_LT(fastest, 0.5 * World::kLargestSpeed);
}

TEST(HandSpeedLimit, CountsTheServersTimeAndForgivesWhatANetworkHeldBack) {
  constexpr double kRecovery = 0.5;
  HandSpeedLimit pace(10.0, kTick, kRecovery);
  std::uint64_t now = 0;
  // 1 kHz at 9.9 m/s for five seconds.
  for (; now < 5000; ++now) ASSERT_TRUE(pace.follow(9.9e-3, now)) << now;
  // No sample arrives for 100 ms. Then all arrive at once.
  now += 100;
  for (int n = 0; n < 100; ++n) ASSERT_TRUE(pace.follow(9.9e-3, now)) << n;
  EXPECT_EQ(pace.trust(now), 1.0);
  EXPECT_FALSE(pace.follow(0.5, now));
  EXPECT_EQ(pace.trust(now), 0.0);
  EXPECT_NEAR(pace.trust(now + 250), 0.5, 1e-12);
  EXPECT_EQ(pace.trust(now + 500), 1.0);
  EXPECT_EQ(pace.trust(now + 5000), 1.0);
}

/// If the world is too slow, the speed of a hand must use the clock instead of the world's steps.
TEST(HandLimits, AHandIsNotTooFastBecauseTheWorldIsSlow) {
  const Material smooth{.stiffness = 1000};
  const Vec3 half(0.2, 0.2, 0.02), low(0, 0, 0.02);
  const Scene scene =
      moving({object("table", Plane{}, smooth), object("plate", Box{half}, smooth, low)}, {-1, 0},
             {body("plate", 5.0, low)});
  MovingBench bench(scene);
  bench.join(kLeft);
  double least = 1e9;
  for (int n = 0; n < 200; ++n) {
    // The speed is some 0.3 m/s by the clock, and up to 100 m/s by the world's steps.
    const double x = 0.1 * std::sin(50.0 * n);
    const double felt = bench.hand(kLeft, {x, 0, 0.039}).command.elastic.z();
    if (n > 20) least = std::min(least, felt);
    bench.advance(400ms);
  }
  EXPECT_GT(bench.sessions.counters().ticks_dropped, 10'000u);
  EXPECT_GT(least, 0.5);
}

}  // namespace
}  // namespace feltwire::hand_limits_test

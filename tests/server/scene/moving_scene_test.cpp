// Tests hands among moving bodies in the server's SceneSessions. The clock is simulated, and each
// hand sends a datagram per millisecond.

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include <cmath>

#include "tests/core/moving.hpp"
#include "tests/server/moving_bench.hpp"

namespace feltwire::moving_scene_test {
namespace {

using namespace std::chrono_literals;
using test::body;
using test::box_on_table;
using test::kGrippy;
using test::kWeightless;
using test::moving;
using test::object;

constexpr double kTick = kDefaultTick;

using test::kLeft, test::kRight, test::kThird, test::kFourth;
using Bench = test::MovingBench;

TEST(MovingScene, WhatTheHandsAreToldTheBodyTakesNegated) {
  const Scene scene =
      moving({object("ball", Sphere{0.03}, kGrippy)}, {0}, {body("ball", 0.2)}, kWeightless);
  Bench bench(scene);
  bench.join(kLeft);
  bench.join(kRight);
  Vec3 told = Vec3::Zero();
  double sum = 0.0;
  for (int n = 0; n < 1000; ++n) {
    const double t = 1e-3 * n;
    const Vec3 centre = bench.place(0);
    for (const auto& [id, place] :
         {std::pair(kLeft, Vec3(-0.0293 + 4e-4 * std::sin(30 * t), 2e-3 * std::sin(9 * t), 0)),
          std::pair(kRight, Vec3(0.0291, 1e-3 * std::sin(20 * t), 2e-3))}) {
      const Vec3 force = bench.hand(id, centre + place).command.force();
      told += kTick * force;
      sum += kTick * force.norm();
    }
    bench.advance();
  }
  ASSERT_GT(sum, 0.5);
  EXPECT_NEAR((bench.world().momentum() + told).norm(), 0.0, 1e-12 * sum);
}

/// Two hands squeeze, lift and carry the box. A second pair takes over, then lets the box fall.
TEST(MovingScene, HandsLiftABoxHandItOverAndLetItFall) {
  const Scene scene = box_on_table();
  Bench bench(scene);
  for (const std::uint64_t id : {kLeft, kRight, kThird, kFourth}) bench.join(id);
  const auto smooth = [](double t, double from, double until) {
    const double s = std::clamp((t - from) / (until - from), 0.0, 1.0);
    return s * s * (3 - 2 * s);
  };
  constexpr double kOutside = 0.03, kGrip = 0.0175;  // [m] from the box's centre; 2.5 mm deep
  double held_height = 0.0, handed_height = 0.0;
  for (int n = 0; n <= 6000; ++n) {
    const double t = 1e-3 * n;
    const double lift = 0.1 * smooth(t, 0.5, 1.5);
    // The first pair grips along x from 0.2 s to 3 s. The second pair grips along y from 2.2 s to
    // 4.5 s.
    const double first =
        kOutside - (kOutside - kGrip) * (smooth(t, 0.0, 0.3) - smooth(t, 3.0, 3.3));
    const double second =
        kOutside - (kOutside - kGrip) * (smooth(t, 2.0, 2.3) - smooth(t, 4.5, 4.8));
    bench.hand(kLeft, {-first, 0, 0.02 + lift});
    bench.hand(kRight, {first, 0, 0.02 + lift});
    bench.hand(kThird, {0, -second, 0.02 + lift});
    bench.hand(kFourth, {0, second, 0.02 + lift});
    bench.advance();
    if (n == 1900) held_height = bench.place(1).z();
    if (n == 4400) handed_height = bench.place(1).z();
  }
  // The weight of 1.98 N is on springs of 1000 N/m. A hand is at most 1 mm above its stick point.
  EXPECT_NEAR(held_height, 0.12, 1e-3);
  EXPECT_NEAR(handed_height, held_height, 1e-3);
  EXPECT_NEAR(bench.place(1).z(), 0.02, 3e-4);  // The box is on the table again.
  EXPECT_EQ(bench.sessions.counters().world.resets, 0u);
  EXPECT_EQ(bench.sessions.counters().ticks_dropped, 0u);
}

TEST(MovingScene, AButtonGivesWayAndComesBack) {
  Body button = body("button", 0.02, {0, 0, 0.01});
  button.joint = Joint::slide;
  button.low = -0.004;
  button.high = 0.0;
  button.stiffness = 300.0;
  button.rest = 0.002;
  button.damping = 1.0;
  const Scene scene = moving(
      {object("cap", Cylinder{0.01, 0.005}, {.stiffness = 1000, .damping = 0.5}, {0, 0, 0.01})},
      {0}, {button});
  Bench bench(scene);
  bench.join(kLeft);
  const auto press = [&](double height, int ticks) {
    Reply reply;
    for (int n = 0; n < ticks; ++n) {
      reply = bench.hand(kLeft, {0, 0, height});
      bench.advance();
    }
    return reply.command.elastic.z();
  };
  press(0.02, 100);
  EXPECT_NEAR(bench.place(0).z(), 0.01, 1e-5);  // The button is at its stop.
  // Two springs are in series. The button's spring is preloaded by 2 mm, and the weight acts too:
  // 300 (2 mm + s) + m g = 1000 (3 mm - s) for the displacement s. The force acts on both sides.
  const double weight = 0.02 * 9.81;
  const double way = (1000 * 0.003 - 300 * 0.002 + weight) / 1300.0;
  EXPECT_NEAR(press(0.012, 1000), 1000 * (0.003 - way), 0.01);
  EXPECT_NEAR(bench.place(0).z(), 0.01 - way, 1e-5);
  // At the lower stop, the stop carries the rest of the force.
  EXPECT_NEAR(press(0.005, 1000), 6.0, 0.1);
  EXPECT_NEAR(bench.place(0).z(), 0.006, 1e-4);
  press(0.03, 500);
  EXPECT_NEAR(bench.place(0).z(), 0.01, 1e-5);
}

/// The force of a silent hand must fade. The force is complete for half of hold_time, and zero
/// after hold_time.
TEST(MovingScene, ASilentHandLetsGo) {
  const Scene scene = moving({object("ball", Sphere{0.03}, {.stiffness = 1000})}, {0},
                             {body("ball", 10.0)}, kWeightless);
  Bench bench(scene);
  SessionParameters parameters;
  parameters.hold_time = 0.04;
  bench.join(kLeft, parameters);
  const double force = bench.hand(kLeft, {-0.029, 0, 0}).command.force().norm();
  std::vector<double> speeds;
  for (int n = 0; n < 60; ++n) {
    bench.advance();
    speeds.push_back(bench.world().momentum().x());
  }
  // 20 ticks have the full force. A fade from 1 to 0 then adds 10 ticks. The ball moves 0.1 mm of 1
  // mm meanwhile.
  EXPECT_NEAR(speeds.back(), force * kTick * 30.5, 0.1 * force * kTick * 30.5);
  EXPECT_EQ(speeds[40], speeds.back());
  EXPECT_LT(speeds[38], speeds[39]);
}

TEST(MovingScene, AHandThatLeavesLetsGoAtOnce) {
  const Scene scene =
      moving({object("ball", Sphere{0.03}, kGrippy)}, {0}, {body("ball", 1.0)}, kWeightless);
  Bench bench(scene);
  bench.join(kLeft);
  bench.join(kRight);
  bench.hand(kLeft, {-0.029, 0, 0});
  bench.sessions.answer(control::LeaveRequest{kLeft}, 0, {}, bench.now);
  for (int n = 0; n < 20; ++n) bench.advance();
  EXPECT_EQ(bench.world().momentum(), Vec3::Zero());
}

TEST(MovingScene, TimeStandsStillWhileNobodyIsHere) {
  const Scene scene = moving({object("ball", Sphere{0.03})}, {0}, {body("ball", 1.0)});
  Bench bench(scene);
  EXPECT_FALSE(bench.sessions.next_tick());
  bench.advance(10s);
  EXPECT_EQ(bench.world().counters().steps, 0u);
  bench.join(kLeft);
  EXPECT_EQ(bench.sessions.next_tick(), bench.now + 1ms);
  bench.advance(5ms);
  EXPECT_EQ(bench.world().counters().steps, 5u);
  bench.sessions.answer(control::LeaveRequest{kLeft}, 0, {}, bench.now);
  bench.advance(1s);
  EXPECT_EQ(bench.world().counters().steps, 5u);
}

TEST(MovingScene, AStallIsNoBurst) {
  const Scene scene = moving({object("ball", Sphere{0.03})}, {0}, {body("ball", 1.0)});
  Bench bench(scene);
  bench.join(kLeft);
  bench.advance(300ms);
  EXPECT_EQ(bench.world().counters().steps, 20u);
  EXPECT_EQ(bench.sessions.counters().ticks_dropped, 280u);
  bench.advance(7ms);
  EXPECT_EQ(bench.world().counters().steps, 27u);
}

TEST(MovingScene, CountsHowLateItsTicksAre) {
  const Scene scene = moving({object("ball", Sphere{0.03})}, {0}, {body("ball", 1.0)});
  Bench bench(scene);
  bench.join(kLeft);
  bench.advance(1ms);     // on time
  bench.advance(1200us);  // 0.2 ms late
  bench.advance(100us);   // too early for another tick
  bench.advance(5900us);  // six ticks, the first 5.2 ms late
  const TimeCounts late = bench.sessions.counters().world_late;
  EXPECT_EQ(late.sum(), 5'400'000u);
  EXPECT_EQ(late.counts()[0], 1u);
  EXPECT_EQ(late.counts()[4], 1u) << "up to 0.2 ms";
  EXPECT_EQ(late.counts()[9], 1u) << "up to 10 ms";
}

/// A tick takes three times its simulated time. Soon no call may make more than one tick.
TEST(MovingScene, AWorldThatCannotKeepUpGoesSlowerInSmallSteps) {
  const Scene scene = moving({object("ball", Sphere{0.03})}, {0}, {body("ball", 1.0)});
  Bench bench(scene);
  bench.join(kLeft);
  std::uint64_t steps = 0;  // steps in a call
  const auto advance = [&](Nanoseconds by) {
    const std::uint64_t before = bench.world().counters().steps;
    bench.advance(by);
    steps = bench.world().counters().steps - before;
  };
  advance(50ms);  // a stall
  EXPECT_EQ(steps, 20u);
  for (int n = 0; n < 20; ++n) {
    advance(3ms * steps);
    EXPECT_LE(steps, std::max(1u, 10u >> n));
  }
  EXPECT_EQ(steps, 1u);
  EXPECT_EQ(bench.sessions.counters().ticks_dropped + bench.world().counters().steps,
            static_cast<std::uint64_t>((bench.now - 1s) / 1ms));
  // When the world is fast enough again, it must make up for stalls as before.
  for (int n = 0; n < 10; ++n) advance(1ms);
  advance(20ms);
  EXPECT_EQ(steps, 20u);
}

/// A timer makes single steps, or the next datagram makes all steps. The results must be equal.
TEST(MovingScene, WhenStepsAreTakenMakesNoDifference) {
  const Scene scene = box_on_table();
  const auto run = [&](bool timer) {
    Bench bench(scene);
    bench.join(kLeft);
    std::vector<double> all;
    for (int n = 0; n < 300; ++n) {
      const double t = 1e-3 * n;
      const Reply reply = bench.hand(kLeft, {-0.022 + 0.02 * t, 0.003, 0.025});
      all.push_back(reply.command.force().x());
      const Nanoseconds gap = (1 + n % 7) * 1ms;
      if (timer)
        for (Nanoseconds d = 0ms; d < gap; d += 500us) bench.advance(500us);
      else
        bench.now += gap;
    }
    bench.advance(0ms);
    all.push_back(bench.place(1).x());
    return all;
  };
  const auto stepped = run(true);
  EXPECT_EQ(stepped, run(false));
  EXPECT_GT(stepped.back(), 1e-4);
}

/// The link of a slow hand must not make a light body oscillate. Between two samples, the body must
/// meet the hand instead of an old force.
TEST(MovingScene, ASlowHandHoldsALightBodyCalmly) {
  constexpr double kStiffness = 2000.0;
  const Scene scene = moving({object("ball", Sphere{0.02}, {.stiffness = kStiffness})}, {0},
                             {body("ball", 0.01)}, kWeightless);
  Bench bench(scene);
  SessionParameters parameters;
  parameters.hold_time = 0.2;
  bench.join(kLeft, parameters);
  bench.join(kRight, parameters);
  double fastest = 0.0;
  for (int n = 0; n < 3000; ++n) {
    if (n % 20 == 0) {  // 50 samples a second; sqrt(2 k / m) is 632 rad/s
      bench.hand(kLeft, {-0.0190, 0, 0});
      bench.hand(kRight, {0.0191, 0, 0});
    }
    bench.advance();
    fastest = std::max(fastest, bench.world().momentum().norm() / 0.01);
  }
  // The ball oscillates about the middle, 50 um away: 0.05 mm times 632 rad/s.
  EXPECT_LT(fastest, 0.04);
}

/// All hands must get a report of a reset, and of the end of the recovery.
TEST(MovingScene, AResetIsToldInTheReplies) {
  const Scene scene = test::explosive();
  Bench bench(scene);
  bench.join(kLeft);
  bench.join(kRight);
  EXPECT_FALSE(bench.hand(kLeft, {0, 0, 0.1705}).recovering);
  for (int n = 0; bench.world().counters().resets == 0 && n < 500; ++n) {
    bench.hand(kLeft, {0, 0, 0.1705});
    bench.advance();
  }
  ASSERT_EQ(bench.world().counters().resets, 1u);
  const Reply reply = bench.hand(kLeft, {0, 0, 0.1705});
  EXPECT_TRUE(reply.recovering);
  EXPECT_EQ(reply.command.force(), Vec3::Zero());
  int told = 0;
  for (int n = 0; n < 600; ++n) {
    told += bench.hand(kRight, {0, 0, 0.5}).recovering ? 1 : 0;  // Each hand gets the report.
    bench.hand(kLeft, {0, 0, 0.1});                              // The hand moves out again.
    bench.advance();
  }
  EXPECT_EQ(bench.world().counters().resets, 1u);
  EXPECT_NEAR(told, 1e3 * World::kRecovery, 1.0);
}

TEST(MovingScene, ReceivingNeverAllocates) {
#ifdef FELTWIRE_SANITIZED
  GTEST_SKIP() << "sanitizers allocate by themselves";
#endif
  const Scene scene = box_on_table();
  Bench bench(scene);
  bench.join(kLeft);
  bench.hand(kLeft, {-0.019, 0, 0.02});
  bench.allocated = 0;
  for (int n = 0; n < 500; ++n) {
    bench.hand(kLeft, {-0.019, 0.005 * std::sin(0.1 * n), 0.02});
    bench.advance();
  }
  EXPECT_EQ(bench.allocated, 0u);
}

/// For a minute a hand with a tremor rests on a box on a table.
TEST(MovingScene, ARestingHandNeitherCreepsNorBuzzes) {
  const Scene scene = box_on_table();
  Bench bench(scene);
  bench.join(kLeft);
  constexpr double kDepth = 1e-3, kTremor = 2e-5;  // [m]
  const auto settle = [&](int ticks, bool tremor) {
    double least = 1e9, most = -1e9;
    for (int n = 0; n < ticks; ++n) {
      const double moved = tremor ? kTremor * std::sin(0.06 * n) : 0.0;  // A tremor of 10 Hz
      const double force =
          bench.hand(kLeft, {0.005 + 20 * moved, 0, 0.04 - kDepth + moved}).command.elastic.z();
      least = std::min(least, force);
      most = std::max(most, force);
      bench.advance();
    }
    return std::pair(least, most);
  };
  settle(2000, true);
  const Vec3 place = bench.place(1);
  const auto [least, most] = settle(58000, true);
  EXPECT_NEAR((bench.place(1) - place).norm(), 0.0, 2e-5);           // The box must not creep.
  EXPECT_NEAR(most - least, 2 * kTremor * kGrippy.stiffness, 0.01);  // Only the tremor may remain.
  const auto [quiet_least, quiet_most] = settle(1000, false);
  EXPECT_LT(quiet_most - quiet_least, 0.05);
}

}  // namespace
}  // namespace feltwire::moving_scene_test

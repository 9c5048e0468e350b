#include "client/servo/servo.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

#include "tests/client/servo_bench.hpp"

namespace feltwire::servo_test {
namespace {

using namespace testing::servo;

TEST(Servo, SamplesAreCountedFromOneAndCarryWhatIsHeld) {
  Bench bench(parameters("none"));
  bench.now += kPeriod;
  const Command given = bench.servo.render(at(1, 2, 3), bench.now);
  EXPECT_EQ(given.force(), Vec3::Zero());
  const Sample* sample = bench.servo.hold(given);
  ASSERT_NE(sample, nullptr);
  EXPECT_EQ(sample->index, 1u);
  EXPECT_EQ(sample->client_time, bench.now);
  EXPECT_EQ(sample->pose.position, Vec3(1, 2, 3));

  bench.servo.take(reply(1, elastic(0, 0, 4)), bench.now);
  bench.now += kPeriod;
  bench.servo.render(at(1, 2, 3), bench.now);
  sample = bench.servo.hold(elastic(0, 0, 3));  // The device gave less force than commanded.
  EXPECT_EQ(sample->index, 2u);
  EXPECT_EQ(sample->held.elastic, Vec3(0, 0, 3));
  EXPECT_EQ(bench.servo.statistics().max_force, 3.0);
  EXPECT_EQ(bench.servo.statistics().samples, 2u);
}

/// The server predicts a line: 2 N that fall by 40 N/s, but never below zero.
TEST(Servo, ACommandIsCarriedOnAlongItsRatesForKeepAliveAtMost) {
  SessionParameters p = parameters("none");
  p.keep_alive = 0.02;
  for (const auto& [ahead, expected] : std::vector<std::pair<double, double>>{
           {0.001, 1.96}, {0.01, 1.6}, {0.02, 1.2}, {0.03, 1.2}, {0.045, 1.2}}) {
    Bench bench(p);
    bench.tick();
    Reply line = reply(1, {.elastic = Vec3(0, 0, 2)});
    line.rates.elastic = Vec3(0, 0, -40);
    line.predicted = true;
    bench.servo.take(line, bench.now);
    EXPECT_NEAR(bench.tick({}, seconds(ahead)).elastic.z(), expected, 1e-9) << ahead;
  }
  for (const double rate : {-1e3, -1e9, kNan, kInfinity}) {
    Bench bench(p);
    bench.tick();
    Reply line = reply(1, {.elastic = Vec3(0, 0, 2)});
    line.rates.elastic = Vec3(0, 0, rate);
    line.predicted = true;
    bench.servo.take(line, bench.now);
    EXPECT_GE(bench.tick({}, seconds(0.01)).elastic.z(), 0.0) << rate;
  }
}

TEST(Servo, WithheldIsNotLost) {
  SessionParameters p = parameters("none");
  p.force_deadband = 0.1;
  p.keep_alive = 0.005;
  Bench bench(p);
  const auto answer = [&](std::uint64_t index, std::uint64_t withheld) {
    Reply r = reply(index, {});
    r.withheld = withheld;
    bench.servo.take(r, bench.now);
  };
  for (int i = 0; i < 10; ++i) {
    bench.tick();
    bench.servo.sent();
  }
  EXPECT_EQ(bench.servo.lost(), 5u);  // The server may have withheld five answers.
  EXPECT_EQ(bench.servo.lost_so_far(), 0u);
  answer(1, 0);
  answer(8, 4);  // The server withheld four of the answers 2 to 7, and two were lost.
  EXPECT_EQ(bench.servo.statistics().replies.withheld, 4u);
  EXPECT_EQ(bench.servo.lost_so_far(), 2u);
  EXPECT_EQ(bench.servo.lost(), 2u);  // The server may have withheld 9 and 10.
  EXPECT_TRUE(bench.servo.awaits_answer());

  bench.servo.reconnected(true);  // The new server counts from zero.
  bench.tick();
  bench.servo.sent();
  answer(11, 0);
  EXPECT_EQ(bench.servo.statistics().replies.withheld, 4u);
  EXPECT_EQ(bench.servo.lost_so_far(), 4u);  // The sum includes 9 and 10 of the old session.
  answer(11, ~std::uint64_t{0});
  EXPECT_LE(bench.servo.lost(), 11u);
}

TEST(Servo, CommandsFadeLinearlyFromHalfTheHoldTimeOn) {
  SessionParameters p = parameters("none");
  p.hold_time = 0.1;
  for (const auto& [age, factor] : std::vector<std::pair<double, double>>{{0.0, 1.0},
                                                                          {0.03, 1.0},
                                                                          {0.05, 1.0},
                                                                          {0.06, 0.8},
                                                                          {0.075, 0.5},
                                                                          {0.095, 0.1},
                                                                          {0.1, 0.0},
                                                                          {3.0, 0.0}}) {
    Bench bench(p);
    bench.tick();
    bench.servo.take(reply(1, {.elastic = Vec3(0, 0, 2), .frictional = Vec3(1, 0, 0)}), bench.now);
    const Command given = bench.tick({}, seconds(age));
    EXPECT_NEAR(given.elastic.z(), 2.0 * factor, 1e-9) << age;
    EXPECT_NEAR(given.frictional.x(), 1.0 * factor, 1e-9) << age;
    EXPECT_EQ(bench.servo.statistics().faded, factor < 1.0 ? 1u : 0u) << age;
    EXPECT_NEAR(bench.servo.command_age(), age, 1e-12);
  }
}

TEST(Servo, OnlyAFreshReplyMakesACommandYoungAgain) {
  SessionParameters p = parameters("none");
  Bench bench(p);
  bench.tick();
  bench.tick();
  EXPECT_TRUE(bench.servo.take(reply(2, elastic(0, 0, 2)), bench.now));
  const Nanoseconds arrived = bench.now;
  bench.tick({}, seconds(0.075));
  EXPECT_FALSE(bench.servo.take(reply(1, elastic(9, 9, 9)), bench.now));  // an older reply
  EXPECT_FALSE(bench.servo.take(reply(2, elastic(9, 9, 9)), bench.now));  // a repeated reply
  const Command given = bench.tick({}, Nanoseconds(0));
  EXPECT_EQ(bench.now - arrived, seconds(0.075));
  EXPECT_TRUE(given.elastic.isApprox(Vec3(0, 0, 1)));
  EXPECT_EQ(bench.servo.statistics().replies.stale, 2u);
  EXPECT_TRUE(bench.servo.take(reply(3, elastic(0, 3, 0)), bench.now));
  // The force rises at the rate of the fade: 40 % in 20 ms.
  EXPECT_TRUE(bench.tick({}, seconds(0.02)).elastic.isApprox(Vec3(0, 0.9 * 3, 0)));
  EXPECT_TRUE(bench.tick({}, seconds(0.02)).elastic.isApprox(Vec3(0, 3, 0)));
}

TEST(Servo, AnswersToSamplesNeverMadeAreRefused) {
  Bench bench(parameters("none"));
  EXPECT_FALSE(bench.servo.take(reply(1, elastic(0, 0, 5)), bench.now));
  bench.tick();
  EXPECT_FALSE(bench.servo.take(reply(0, elastic(0, 0, 5)), bench.now));
  EXPECT_FALSE(bench.servo.take(reply(2, elastic(0, 0, 5)), bench.now));
  EXPECT_FALSE(bench.servo.take(reply(std::numeric_limits<std::uint64_t>::max(), elastic(0, 0, 5)),
                                bench.now));
  EXPECT_EQ(bench.servo.statistics().replies.refused, 4u);
  EXPECT_EQ(bench.servo.statistics().replies.answered, 0u);
  EXPECT_EQ(bench.tick().force(), Vec3::Zero());
  // The refused answers must not block the true reply.
  EXPECT_TRUE(bench.servo.take(reply(1, elastic(0, 0, 1)), bench.now));
  EXPECT_EQ(bench.tick().force(), Vec3(0, 0, 1));
}

TEST(Servo, NotFiniteOrAbsurdRepliesGiveNoForce) {
  for (const double bad : {kNan, kInfinity, -kInfinity, 1e300}) {
    for (const BoundingSide side : {BoundingSide::client, BoundingSide::server}) {
      for (const std::string_view mode : {"none", "contact_frame", "per_axis"}) {
        Bench bench(parameters(mode, side));
        bench.tick();
        bench.servo.take(reply(1, {.elastic = Vec3(0, 0, 1), .frictional = Vec3(bad, 0, 0)}),
                         bench.now);
        EXPECT_EQ(bench.tick(at(0, 0, -0.01)).force(), Vec3::Zero()) << bad;
        EXPECT_EQ(bench.tick(at(0, 0, -0.02)).force(), Vec3::Zero()) << bad;
        EXPECT_EQ(bench.servo.statistics().replies.refused, 1u) << bad;
      }
    }
  }
}

TEST(Servo, FaultyReadingsGiveNoForceAndTheLastGoodPose) {
  const Quaternion no_rotation(0, 0, 0, 0), nan_rotation(kNan, 0, 0, 0);
  const std::vector<DeviceReading> faulty = {
      {.pose = {.position = Vec3(0, 0, 0)}, .ok = false},
      at(kNan, 0, 0),
      at(0, kInfinity, 0),
      {.pose = {.position = Vec3::Zero(), .orientation = no_rotation}},
      {.pose = {.position = Vec3::Zero(), .orientation = nan_rotation}},
  };
  for (const DeviceReading& reading : faulty) {
    Bench bench(parameters("none"));
    bench.tick(at(1, 2, 3));
    bench.servo.take(reply(1, elastic(0, 0, 2)), bench.now);
    EXPECT_EQ(bench.tick(at(1, 2, 3)).force(), Vec3(0, 0, 2));
    EXPECT_EQ(bench.tick(reading).force(), Vec3::Zero());
    EXPECT_EQ(bench.servo.sample().pose.position, Vec3(1, 2, 3));
    EXPECT_EQ(bench.servo.statistics().device.faults, 1u);
    // The hand moved during the fault. The work of this jump is unknown and must not count.
    const double before = bench.servo.port().delivered().total();
    bench.tick(at(9, 9, 9));
    EXPECT_EQ(bench.servo.port().delivered().total(), before);
    EXPECT_EQ(bench.servo.sample().pose.position, Vec3(9, 9, 9));
  }
}

TEST(Servo, AJumpAcrossAFaultEarnsNoForce) {
  Bench bench(parameters("contact_frame"));
  bench.tick(at(0, 0, 0));
  bench.servo.take(reply(1, elastic(0, 0, 50)), bench.now);
  bench.tick({.pose = {}, .ok = false});
  // The bound would allow c * 50 mm = 50 N.
  EXPECT_EQ(bench.tick(at(0, 0, -0.05)).force(), Vec3::Zero());
  EXPECT_GT(bench.tick(at(0, 0, -0.051)).force().z(), 0.0);
}

TEST(Servo, SaysNothingBeforeTheFirstGoodReading) {
  Bench bench(parameters("none"));
  bench.servo.render({.pose = {}, .ok = false}, bench.now);
  EXPECT_EQ(bench.servo.hold({}), nullptr);
  bench.servo.render(at(1, 0, 0), bench.now + kPeriod);
  const Sample* sample = bench.servo.hold({});
  ASSERT_NE(sample, nullptr);
  EXPECT_EQ(sample->index, 1u);
}

TEST(Servo, WhatADeviceCannotSayItHoldsIsAFault) {
  Bench bench(parameters("contact_frame"));
  bench.tick(at(0, 0, 0));
  bench.servo.render(at(0, 0, 0), bench.now += kPeriod);
  const Sample* sample = bench.servo.hold(elastic(kNan, 0, 0));
  EXPECT_EQ(sample->held.force(), Vec3::Zero());
  EXPECT_EQ(bench.servo.statistics().device.faults, 1u);
}

TEST(Servo, WhatTheDeviceReallyHeldIsWhatTheBoundBuildsOn) {
  for (const double share : {1.0, 0.25, 0.0}) {
    Bench bench(parameters("contact_frame"));
    bench.tick(at(0, 0, 0));
    bench.servo.take(reply(1, elastic(0, 0, 2)), bench.now);
    const Command given = bench.servo.render(at(0, 0, -1e-3), bench.now += kPeriod);
    ASSERT_GT(given.force().z(), 0.0);
    bench.servo.hold(share * given);
    // At rest the method allows exactly the held force.
    EXPECT_NEAR(bench.tick(at(0, 0, -1e-3)).force().z(), share * given.force().z(), 1e-12);
  }
}

TEST(Servo, TheDevicesEndGivesNoForce) {
  Bench ended(parameters("none"));
  ended.tick();
  ended.servo.take(reply(1, elastic(0, 0, 2)), ended.now);
  EXPECT_EQ(ended.tick().force(), Vec3(0, 0, 2));
  EXPECT_FALSE(ended.servo.device_ended());
  EXPECT_EQ(ended.tick({.pose = {}, .ended = true}).force(), Vec3::Zero());
  EXPECT_TRUE(ended.servo.device_ended());
  EXPECT_TRUE(ended.servo.let_go());
}

TEST(Servo, ASpringAtTheLimitIsRenderedUndiminished) {
  // k = c = 2 b / T: the hand presses and releases along a constant normal.
  Bench bench(parameters("contact_frame"));
  constexpr double kStiffness = 1000.0;
  double z = 0.0;
  bench.tick(at(0, 0, z));
  for (int i = 1; i < 40; ++i) {
    z = -1e-3 * std::sin(i * 3.14159265 / 40.0);
    bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, -kStiffness * z)), bench.now);
    EXPECT_NEAR(bench.tick(at(0, 0, z)).force().z(), -kStiffness * z, 1e-9);
  }
  EXPECT_EQ(bench.servo.statistics().law.bound_active, 0u);
  EXPECT_EQ(bench.servo.port().violations(), 0u);
}

TEST(Servo, OnTheServersSideTheGuardAndTheSafetyClampsStay) {
  Bench bench(parameters("contact_frame", BoundingSide::server));
  bench.tick();
  bench.servo.take(reply(1, elastic(0, 0, 7)), bench.now);
  EXPECT_EQ(bench.tick().force(), Vec3::Zero());  // The device has not dissipated energy yet.
  EXPECT_EQ(bench.servo.statistics().law.account_cut, 1u);
  EXPECT_EQ(bench.servo.account_cut(), 1.0);
  for (int n = 1; n <= 30; ++n) bench.tick(at(2e-3 * n, 0, 0));
  EXPECT_EQ(bench.tick(at(0.06, 0, 0)).force(),
            Vec3(0, 0, 7));  // A client's bound would allow no force at rest.
  EXPECT_EQ(bench.servo.account_cut(), 0.0);
  bench.servo.take(reply(2, elastic(300, 0, 400)), bench.now);
  EXPECT_TRUE(
      bench.tick(at(0.06, 0, 0)).force().isApprox(bench.spec.max_force * Vec3(0.6, 0, 0.8)));
  EXPECT_EQ(bench.servo.statistics().law.saturated, 1u);
}

TEST(Servo, WhatTheDeviceDoesNotActuateIsNotGiven) {
  Bench bench(parameters("none"));
  Servo flat(builtin_device("impulse_engine_2000"), parameters("none"));
  flat.render({}, bench.now);
  flat.hold({});
  flat.take(reply(1, {.elastic = Vec3(1, 0, 5), .torque = Vec3(1, 1, 1)}), bench.now);
  const Command given = flat.render({}, bench.now + kPeriod);
  EXPECT_EQ(given.force(), Vec3(1, 0, 0));
  EXPECT_EQ(given.torque, Vec3::Zero());
  flat.hold(given);
  EXPECT_EQ(flat.statistics().direction_error.max(), 0u);  // The direction error is zero.
}

TEST(Servo, CountsEachAnswerOnceAndMeasuresFromTheSample) {
  Bench bench(parameters("none"));
  for (int i = 0; i < 4; ++i) bench.tick();
  const Nanoseconds last = bench.now;
  bench.servo.take(reply(4, {}), last + std::chrono::microseconds(200));
  bench.servo.take(reply(2, {}),
                   last + std::chrono::microseconds(300));  // 2.3 ms: late, but a valid answer
  bench.servo.take(reply(2, {}), last + std::chrono::microseconds(400));
  bench.servo.take(reply(4, {}), last + std::chrono::microseconds(400));
  const ServoStatistics& s = bench.servo.statistics();
  EXPECT_EQ(s.replies.answered, 2u);
  EXPECT_EQ(s.replies.late, 1u);
  EXPECT_EQ(s.replies.round_trip.count(), 2u);
  EXPECT_EQ(s.replies.round_trip.max(), 2'300'000u);
  EXPECT_NEAR(s.replies.round_trip.quantile(0.5), 200'000.0, 200'000.0 / 256.0);
}

TEST(Servo, DirectionErrorIsTheAngleToTheCommand) {
  Bench bench(parameters("none"));
  bench.tick();
  bench.servo.take(reply(1, elastic(0, 0, 2)), bench.now);
  bench.servo.render({}, bench.now += kPeriod);
  bench.servo.hold(elastic(1, 0, 1));  // The device's force has a direction error of 45 degrees.
  bench.servo.render({}, bench.now += kPeriod);
  bench.servo.hold(elastic(0, 0, 1e-7));  // too small for a direction
  const Histogram& h = bench.servo.statistics().direction_error;
  EXPECT_EQ(h.count(), 1u);
  EXPECT_NEAR(h.mean(), 45e6, 1.0);
}

TEST(Servo, EnergyIsThatOfTheHeldForceOverTheMovement) {
  Bench bench(parameters("none"));
  bench.tick(at(0, 0, 0));
  bench.servo.take(reply(1, {.elastic = Vec3(0, 0, 2), .frictional = Vec3(-1, 0, 0)}), bench.now);
  bench.tick(at(0, 0, 0));
  bench.tick(at(0.5e-3, 0, 1.5e-3));
  const ChannelEnergy& e = bench.servo.port().delivered();
  EXPECT_NEAR(e.elastic, 3e-3, 1e-15);
  EXPECT_NEAR(e.frictional, -0.5e-3, 1e-15);
}

TEST(Servo, TheSameInputsGiveTheSameBits) {
  const auto run = [] {
    Bench bench(parameters("contact_frame"));
    std::mt19937_64 random(3);
    std::uniform_real_distribution<double> spread(-1e-3, 1e-3);
    Vec3 sum = Vec3::Zero();
    for (int i = 0; i < 2000; ++i) {
      sum += bench.tick(at(spread(random), spread(random), spread(random))).force();
      bench.servo.take(
          reply(bench.servo.sample().index, elastic(spread(random), 1e3 * spread(random), 1.0)),
          bench.now);
    }
    return sum;
  };
  const Vec3 first = run();
  EXPECT_EQ(first, run());
  EXPECT_GT(first.norm(), 0.0);
}

}  // namespace
}  // namespace feltwire::servo_test

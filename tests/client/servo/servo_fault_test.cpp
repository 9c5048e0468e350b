// After a fault the force must fade without a step (PROTOCOL.md, "Faults").

#include <gtest/gtest.h>

#include "tests/client/servo_bench.hpp"
#include "tests/core/support.hpp"
#include "tests/support/seeds.hpp"

namespace feltwire::servo_fault_test {
namespace {

using namespace testing::servo;

constexpr double kHoldTime = 0.1;  // [s] the default
constexpr int kHalf = 50;          // [ticks] half the hold time

ServoOptions wait_for_small_force() { return {.safety = {.force = {.small = 0.05}}}; }

/// Returns a servo that holds `force` [N] upwards after a fresh answer.
Bench holding(double force, const ServoOptions& options = {}, std::string_view mode = "none") {
  Bench bench(parameters(mode), options);
  bench.tick();
  bench.servo.take(reply(1, {}), bench.now);
  bench.tick();
  bench.servo.take(reply(2, elastic(0, 0, force)), bench.now);
  bench.tick();
  return bench;
}
bool answer(Bench& bench, double force) {
  return bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, force)), bench.now);
}

TEST(ServoFault, AReleasedHandIsLetGoWithinHalfTheHoldTime) {
  Bench bench = holding(2.0);
  bench.servo.release();
  EXPECT_FALSE(bench.servo.let_go());
  for (int n = 1; n <= kHalf; ++n) {
    EXPECT_NEAR(bench.tick().force().z(), 2.0 * (kHalf - n) / kHalf, 1e-9) << n;
    EXPECT_EQ(bench.servo.let_go(), n == kHalf) << n;
    answer(bench, 7.0);  // The servo must ignore this answer.
  }
  for (int n = 0; n < 10; ++n) {
    answer(bench, 7.0);
    EXPECT_EQ(bench.tick().force(), Vec3::Zero());
  }
  EXPECT_EQ(bench.servo.statistics().replies.answered, bench.servo.statistics().samples - 2);
}

TEST(ServoFault, AReleaseLatePutsNothingOff) {
  Bench bench = holding(2.0);
  // After 80 silent ticks, 20 ms or 40 % of the fade remain.
  for (int n = 0; n < 80; ++n) bench.tick();
  EXPECT_NEAR(bench.tick().force().z(), 2.0 * 0.36, 1e-9);
  bench.servo.release();
  for (int n = 0; n < 18; ++n) bench.tick();
  EXPECT_TRUE(bench.servo.let_go());
}

/// The scene commands far more force than the device's limit. The fade must begin at this limit.
TEST(ServoFault, AnEnormousCommandFadesAsLongAsAnyOther) {
  Bench bench = holding(1e5);
  const double most = bench.spec.max_force;
  EXPECT_NEAR(bench.servo.held().force().z(), most, 1e-9);
  bench.servo.release();
  for (int n = 1; n <= kHalf; ++n)
    EXPECT_NEAR(bench.tick().force().z(), most * (kHalf - n) / kHalf, 1e-9) << n;
}

/// Some methods bound a force from below. Such a method must not keep force on a moving hand at the
/// end.
TEST(ServoFault, AtTheEndNoLawHoldsOnToAnything) {
  for (const std::string_view mode : {"total_energy", "per_axis", "per_axis_projected"}) {
    for (const bool release : {true, false}) {
      Bench bench(parameters(mode));
      double z = 0.0;
      bench.tick(at(0, 0, z));
      for (int n = 0; n < 20; ++n) {
        answer(bench, 4.0);
        bench.tick(at(0, 0, z -= 1e-3));
      }
      EXPECT_GT(bench.servo.held().force().z(), 1.0) << mode;
      if (release) bench.servo.release();
      // The hand moves out slowly. The method lets the force fall by at most c1 per metre.
      for (int n = 0; n < 2 * kHalf - 2; ++n) bench.tick(at(0, 0, z += 1e-6));
      if (!release && mode != "total_energy") {
        EXPECT_GT(bench.servo.held().force().z(), 1.0) << mode;
      }
      for (int n = 0; n < 2; ++n) bench.tick(at(0, 0, z += 1e-6));
      EXPECT_EQ(bench.servo.held().force(), Vec3::Zero()) << mode;
      EXPECT_EQ(bench.servo.port().violations(), 0u) << mode;
    }
  }
}

TEST(ServoFault, AReconnectedHandIsLetGoThenWaits) {
  Bench bench = holding(2.0, wait_for_small_force());
  EXPECT_EQ(bench.servo.held().force().z(), 2.0);
  bench.servo.reconnected(true);
  for (int n = 1; n <= kHalf; ++n) {
    answer(bench, 8.0);  // first replies of the new session
    EXPECT_NEAR(bench.tick().force().z(), 2.0 * (kHalf - n) / kHalf, 1e-9) << n;
  }
  for (int n = 0; n < kHalf; ++n) {
    answer(bench, 8.0);
    EXPECT_EQ(bench.tick().force(), Vec3::Zero());
  }
  answer(bench, 0.0);  // The hand is outside.
  bench.tick();
  answer(bench, 3.0);
  EXPECT_EQ(bench.tick().force().z(), 3.0);
}

/// A reply to an earlier sample must not end the wait for a small force.
TEST(ServoFault, NoWordFromBeforeEndsTheWait) {
  const auto reconnect = [](Bench& bench) { bench.servo.reconnected(true); };
  const auto fail = [](Bench& bench) { bench.tick({.pose = {}, .ok = false}); };
  for (const bool device : {false, true}) {
    Bench bench = holding(0.0, wait_for_small_force());  // in free space
    const std::uint64_t before = bench.servo.sample().index;
    bench.tick();
    device ? fail(bench) : reconnect(bench);
    for (int n = 0; n < 3; ++n) bench.tick();
    // a reply that the server sent before the fault
    EXPECT_TRUE(bench.servo.take(reply(before, {}), bench.now));
    bench.tick();
    answer(bench, 8.0);
    EXPECT_EQ(bench.tick().force(), Vec3::Zero()) << device;
    answer(bench, 0.0);
    bench.tick();
    answer(bench, 8.0);
    EXPECT_EQ(bench.tick().force().z(), 8.0) << device;
  }
}

TEST(ServoFault, AfterADeviceFaultTheLimitsBeginAnew) {
  Bench waiting = holding(2.0, wait_for_small_force());
  EXPECT_EQ(waiting.servo.held().force().z(), 2.0);
  EXPECT_EQ(waiting.tick({.pose = {}, .ok = false}).force(), Vec3::Zero());
  for (int n = 0; n < 10; ++n) {
    answer(waiting, 2.0);
    EXPECT_EQ(waiting.tick().force(), Vec3::Zero());
  }
  EXPECT_EQ(waiting.servo.statistics().law.waiting, 10u);

  Bench ramped = holding(2.0, {.safety = {.ramp_up = 0.01}});
  for (int n = 0; n < 20; ++n) ramped.tick();
  EXPECT_EQ(ramped.servo.held().force().z(), 2.0);
  ramped.tick({.pose = {}, .ok = false});
  for (int n = 0; n < 10; ++n) EXPECT_NEAR(ramped.tick().force().z(), 0.2 * n, 1e-9) << n;
}

/// The hand moved during the outage. The scene then commands more force.
TEST(ServoFault, AForceThatFadedForWantOfAnswersWaitsAnewHoweverShortTheOutage) {
  for (const double outage : {0.1, 0.101, 0.15, 0.5, 1.0, 1.9}) {
    for (const bool stood_still : {false, true}) {
      Bench bench = holding(2.0, wait_for_small_force());
      if (stood_still)
        bench.tick({}, seconds(outage));
      else
        for (double t = 0.0; t < outage; t += 1e-3) bench.tick();
      EXPECT_EQ(bench.servo.held().force(), Vec3::Zero()) << outage;
      for (int n = 0; n < 50; ++n) {
        answer(bench, 5.0);
        EXPECT_EQ(bench.tick().force(), Vec3::Zero()) << outage << " " << n;
      }
      EXPECT_EQ(bench.servo.no_force(), ZeroForceReason::waiting) << outage;
      answer(bench, 0.0);  // The hand is outside.
      bench.tick();
      answer(bench, 3.0);
      EXPECT_EQ(bench.tick().force().z(), 3.0) << outage;
    }
  }
}

TEST(ServoFault, ARampBeginsAnewAfterAnOutage) {
  Bench bench = holding(2.0, {.safety = {.ramp_up = 0.2}});
  for (int n = 0; n < 300; ++n) {
    answer(bench, 2.0);
    bench.tick();
  }
  EXPECT_EQ(bench.servo.held().force().z(), 2.0);
  for (int n = 0; n < 120; ++n) bench.tick();
  for (int n = 0; n < 200; ++n) {
    answer(bench, 5.0);
    EXPECT_LE(bench.tick().force().z(), 5.0 * (n + 1) / 200.0 + 1e-9) << n;
  }
}

/// An answer to a sample from the outage must not end the wait for a small force.
TEST(ServoFault, AnAnswerFromTheOutageEndsNoWait) {
  Bench bench = holding(2.0, wait_for_small_force());
  for (int n = 0; n < 150; ++n) bench.tick();
  const std::uint64_t before = bench.servo.sample().index;
  for (int n = 0; n < 3; ++n) bench.tick();
  EXPECT_TRUE(bench.servo.take(reply(before, {}), bench.now));
  bench.tick();
  answer(bench, 5.0);
  EXPECT_EQ(bench.tick().force(), Vec3::Zero());
}

/// A partly faded force must not rise faster than its fade.
TEST(ServoFault, AForceThatFadedInPartComesBackSlowly) {
  for (const int silent : {60, 75, 90, 97}) {
    Bench bench = holding(2.0, wait_for_small_force());
    for (int n = 0; n < silent; ++n) bench.tick();
    const double left = bench.servo.held().force().z() / 2.0;
    ASSERT_GT(left, 0.0);
    ASSERT_LT(left, 1.0);
    for (int n = 1; n <= kHalf; ++n) {
      answer(bench, 6.0);
      EXPECT_NEAR(bench.tick().force().z(), 6.0 * std::min(1.0, left + n / double{kHalf}), 1e-9)
          << silent << " " << n;
    }
  }
}

/// The device stops giving force. The run must not end as a success.
TEST(ServoFault, ADeviceThatGivesNothingIsInTrouble) {
  Bench bench = holding(2.0);
  EXPECT_FALSE(bench.servo.device_trouble());
  for (int n = 0; n < 20; ++n) bench.tick({.pose = {}, .ok = false});
  EXPECT_FALSE(bench.servo.device_trouble()) << "that may pass";
  for (int n = 0; n < 20; ++n) bench.tick({.pose = {}, .ok = false});
  ASSERT_TRUE(bench.servo.device_trouble());
  EXPECT_EQ(bench.servo.device_trouble()->reason, ZeroForceReason::device_fault);
  EXPECT_NEAR(bench.servo.device_trouble()->time, 0.04, 1e-9);
  bench.servo.release();
  bench.tick({.pose = {}, .ok = false});
  EXPECT_TRUE(bench.servo.device_trouble());
  bench.tick();
  EXPECT_FALSE(bench.servo.device_trouble());
}

TEST(ServoFault, ADeviceThatHoldsNothingIsInTrouble) {
  Bench bench = holding(2.0);
  const auto refuse = [&](int ticks) {
    for (int n = 0; n < ticks; ++n) {
      answer(bench, 2.0);
      bench.servo.render({}, bench.now += kPeriod);
      bench.servo.hold({});
    }
  };
  refuse(20);
  EXPECT_FALSE(bench.servo.device_trouble());
  answer(bench, 2.0);
  bench.tick();
  refuse(30);
  ASSERT_TRUE(bench.servo.device_trouble());
  EXPECT_EQ(bench.servo.device_trouble()->reason, ZeroForceReason::not_held);
  // A clutch or a withheld force is no device trouble.
  Bench clutched = holding(2.0);
  for (int n = 0; n < 100; ++n) clutched.tick({.pose = {}, .clutched = true});
  EXPECT_FALSE(clutched.servo.device_trouble());
}

/// The process is suspended for seconds. The servo must drop old replies and use new ones.
TEST(ServoFault, ASuspendedProcessTakesNoOldReplyForAFreshOne) {
  for (const int backlog : {0, 1, 5}) {
    Bench bench = holding(2.0);
    for (int n = 0; n < 20; ++n) bench.tick();
    const std::uint64_t before = bench.servo.sample().index;
    bench.now += seconds(3.0);
    // The test delivers replies before the tick and after the tick.
    for (int n = 10; n > backlog; --n)
      bench.servo.take(reply(before - static_cast<std::uint64_t>(n), elastic(0, 0, 5)), bench.now);
    EXPECT_EQ(bench.tick({}, Nanoseconds(0)).force(), Vec3::Zero());
    for (int n = backlog; n > 0; --n)
      bench.servo.take(reply(before + 1 - static_cast<std::uint64_t>(n), elastic(0, 0, 5)),
                       bench.now);
    EXPECT_EQ(bench.tick().force(), Vec3::Zero()) << backlog;
    EXPECT_TRUE(answer(bench, 1.0));
    // The force rises at the rate of a fade.
    EXPECT_NEAR(bench.tick().force().z(), 1.0 / kHalf, 1e-9);
  }
}

TEST(ServoFault, AStumbleIsCountedAsAge) {
  Bench bench = holding(2.0);
  bench.now += seconds(0.08);
  answer(bench, 2.0);  // The answer may have arrived at any time since the last tick.
  EXPECT_NEAR(bench.tick({}, Nanoseconds(0)).force().z(), 2.0 * (0.1 - 0.078) / 0.05, 1e-9);
}

TEST(ServoFault, AClockThatIsSetBackHoldsNothingLonger) {
  for (const double back : {1e-3, 0.5, 1000.0}) {
    Bench bench = holding(2.0);
    for (int n = 0; n < 10; ++n) bench.tick();
    bench.now -= seconds(back) + kPeriod;
    int ticks = 10;
    while (bench.tick().force().z() > 0.0 && ticks < 1000) ++ticks;
    EXPECT_NEAR(ticks, 2 * kHalf, 2) << back;
  }
  Bench released = holding(2.0);
  released.servo.release();
  released.now -= seconds(5.0);
  for (int n = 0; n < kHalf; ++n) released.tick();
  EXPECT_TRUE(released.servo.let_go());
}

TEST(ServoFault, RepliesThatCannotBeLeaveTheOldOneToFade) {
  Bench bench = holding(2.0);
  for (int n = 1; n <= 2 * kHalf; ++n) {
    const std::uint64_t index = bench.servo.sample().index;
    EXPECT_FALSE(bench.servo.take(reply(index, elastic(kNan, 0, 9)), bench.now));
    EXPECT_FALSE(bench.servo.take(reply(index, elastic(0, 0, kInfinity)), bench.now));
    EXPECT_FALSE(bench.servo.take(reply(index, elastic(0, 0, 1e300)), bench.now));
    EXPECT_FALSE(bench.servo.take(reply(index + 1, elastic(0, 0, 9)), bench.now));
    EXPECT_FALSE(bench.servo.take(reply(index + 1'000'000, elastic(0, 0, 9)), bench.now));
    const double factor = std::min(1.0, (2.0 * kHalf - n - 1) / kHalf);
    EXPECT_NEAR(bench.tick().force().z(), 2.0 * std::max(factor, 0.0), 1e-9) << n;
  }
  EXPECT_EQ(bench.servo.statistics().replies.refused, 10u * kHalf);
}

/// A scene commands a constant force, a hand presses or rests, and all kinds of faults occur. The
/// force must not rise faster than the slew limit. The force must not fall faster than the largest
/// force in half the hold time, except after a failed reading. `most` gets the largest held force.
void expect_no_step(const SessionParameters& p, SafetyLimits limits, std::uint64_t seed,
                    double& most) {
  constexpr double kSlew = 120.0;  // [N/s]
  limits.force.slew = kSlew;
  test::Random random(seed);
  Bench bench(p, {.safety = limits});
  const double fall = bench.spec.max_force / (0.5 * p.hold_time);
  const double wanted = std::pow(10.0, random.uniform(-1.0, 5.0));  // [N]
  double z = 0.0, before = 0.0;
  int silent = 0;  // ticks
  bench.tick(at(0, 0, z));
  bench.servo.take(reply(1, {}), bench.now);
  const int release = static_cast<int>(random.uniform(200.0, 1500.0));
  for (int n = 0; n < release + kHalf; ++n) {
    Nanoseconds step = kPeriod;
    double time = p.servo_period;
    bool failed = false;
    if (n == release) bench.servo.release();
    if (random.chance(0.01)) silent = static_cast<int>(random.uniform(1.0, 250.0));
    if (random.chance(0.005)) bench.servo.reconnected(true);
    if (random.chance(0.005)) step = -seconds(random.uniform(0.0, 10.0));
    if (random.chance(0.005)) time = random.uniform(1.0, 4.0) * p.hold_time, step = seconds(time);
    if (random.chance(0.003)) failed = true;
    if (random.chance(0.02)) answer(bench, kNan);
    if (random.chance(0.02)) bench.servo.take(reply(~0ull, elastic(0, 0, wanted)), bench.now);
    if (random.chance(0.02)) bench.servo.take(reply(1, elastic(0, 0, wanted)), bench.now);
    if (--silent < 0) answer(bench, wanted);
    if (random.chance(0.5)) z -= random.uniform(0.0, 2e-3);
    DeviceReading reading = at(0, 0, z);
    reading.ok = !failed;
    const double now = bench.tick(reading, step).force().norm();
    ASSERT_LE(now, before + kSlew * time + 1e-9) << seed << " " << n;
    const double least = failed ? 0.0 : before - fall * time;
    ASSERT_GE(now, least - 1e-9) << seed << " " << n;
    before = now;
    most = std::max(most, now);
  }
  EXPECT_TRUE(bench.servo.let_go()) << seed;
  if (p.mode == "contact_frame" && p.side != BoundingSide::server) {
    EXPECT_EQ(bench.servo.port().violations(), 0u) << seed;
  }
}

TEST(ServoFault, NothingSteps) {
  const SafetyLimits all_limits[] = {{}, {.ramp_up = 0.2}, {.force = {.small = 0.05}}};
  const SessionParameters all_parameters[] = {parameters("none"), parameters("contact_frame"),
                                              parameters("contact_frame", BoundingSide::server),
                                              parameters("energy_tank")};
  for (const SafetyLimits& limits : all_limits) {
    for (const SessionParameters& p : all_parameters) {
      double most = 0.0;
      for (const std::uint64_t seed : test::seeds(1, 60, 6)) expect_no_step(p, limits, seed, most);
      EXPECT_GT(most, 5.0) << p.mode;  // [N] The attack must produce a force.
    }
  }
}

}  // namespace
}  // namespace feltwire::servo_fault_test

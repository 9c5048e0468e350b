// Tests the safety stage between the servo's bound and the device.

#include <gmock/gmock.h>

#include "core/base/numeric.hpp"
#include "tests/client/servo_bench.hpp"
#include "tests/client/temporary_folder.hpp"

namespace feltwire::servo_safety_test {
namespace {

using namespace testing::servo;
using ::testing::AllOf;
using testing::error_of;
using ::testing::HasSubstr;

TEST(ServoSafety, SlewLimitsTheRiseOnly) {
  Bench bench(parameters("none"), {.safety = {.force = {.slew = 500.0}}});  // 0.5 N a tick
  bench.tick();
  bench.servo.take(reply(1, elastic(0, 3, 4)), bench.now);
  for (const double expected : {0.5, 1.0, 1.5})
    EXPECT_NEAR(bench.tick().force().norm(), expected, 1e-12);
  EXPECT_TRUE(direction(bench.servo.held().force()).isApprox(Vec3(0, 0.6, 0.8)));
  bench.servo.take(reply(4, elastic(0, 0, 0.1)), bench.now);
  EXPECT_NEAR(bench.tick().force().norm(), 0.1, 1e-12);
  EXPECT_EQ(bench.servo.statistics().law.slewed, 3u);
}

TEST(ServoSafety, SlewStartsFromWhatTheDeviceHeld) {
  Bench bench(parameters("none"), {.safety = {.force = {.slew = 500.0}}});
  bench.tick();
  bench.servo.take(reply(1, elastic(0, 0, 5)), bench.now);
  for (int i = 0; i < 4; ++i) bench.tick();
  bench.servo.render({}, bench.now += kPeriod);
  bench.servo.hold({});  // The device skipped a write.
  EXPECT_NEAR(bench.tick().force().norm(), 0.5, 1e-12);
}

TEST(ServoSafety, AMaximumBelowTheDevicesOwnGoesWithEveryMode) {
  Bench bench(parameters("none"), {.safety = {.force = {.max = 2.0}}});
  bench.tick();
  bench.servo.take(reply(1, elastic(0, 3, 4)), bench.now);
  EXPECT_TRUE(bench.tick().force().isApprox(Vec3(0, 1.2, 1.6)));
  EXPECT_EQ(bench.servo.statistics().law.force_limited, 1u);
  EXPECT_EQ(bench.servo.statistics().law.saturated, 0u);
  for (const std::string_view mode : bounding_method_names())
    EXPECT_NO_THROW(validate({.safety = {.force = {.max = 2.0, .small = 0.1}}}, parameters(mode)));
}

TEST(ServoSafety, ADeviceThatIsTooFastLosesItsForce) {
  Bench bench(parameters("none"), {.safety = {.force = {.speed = 1.0}}});
  bench.tick();
  bench.servo.take(reply(1, elastic(0, 0, 4)), bench.now);
  double z = 0.0;
  for (int i = 0; i < 40; ++i) bench.tick(at(0, 0, z += 0.9e-3));
  EXPECT_EQ(bench.servo.statistics().law.too_fast, 0u);
  EXPECT_EQ(bench.servo.held().force(), Vec3(0, 0, 4));
  for (int i = 0; i < 40; ++i) {
    bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 4)), bench.now);
    bench.tick(at(0, 0, z += 3e-3));
  }
  EXPECT_EQ(bench.servo.held().force(), Vec3::Zero());
  EXPECT_GT(bench.servo.statistics().law.too_fast, 30u);
}

TEST(ServoSafety, LimitsOnGrowthGoOnlyWithModesThatAdmitThem) {
  const DeviceSpec& spec = builtin_device("simulated");
  struct Case {
    SafetyLimits limits;
    const char* said;
  };
  const Case cases[] = {
      {{.force = {.slew = 500.0}}, "slew limit of 500 N/s"},
      {{.torque = {.slew = 5.0}}, "slew limit of 5 N m/s"},
      {{.force = {.speed = 1.5}}, "velocity limit of 1.5 m/s"},
      {{.torque = {.speed = 9.0}}, "velocity limit of 9 rad/s"},
      {{.ramp_up = 0.2}, "ramp-up of 0.2 s"},
  };
  for (const Case& c : cases) {
    for (const std::string_view mode : {"total_energy", "per_axis", "per_axis_projected"}) {
      EXPECT_THAT(error_of<std::invalid_argument>(
                      [&] { Servo(spec, parameters(mode), {.safety = c.limits}); }),
                  AllOf(HasSubstr(c.said), HasSubstr(std::string(mode)),
                        HasSubstr("use contact_frame or no")));
      EXPECT_THROW(Servo(spec, parameters(mode, BoundingSide::server), {.safety = c.limits}),
                   std::invalid_argument);
    }
    for (const std::string_view mode : {"none", "contact_frame", "energy_tank"})
      EXPECT_NO_THROW(Servo(spec, parameters(mode), {.safety = c.limits}));
  }
  EXPECT_THAT(error_of<std::invalid_argument>(
                  [&] { Servo(spec, parameters("none"), {.safety = {.force = {.slew = 0.0}}}); }),
              HasSubstr("force.slew = 0"));
}

TEST(ServoSafety, WhatProtectsAHandGoesWithEveryMode) {
  for (const std::string_view mode : bounding_method_names())
    for (const BoundingSide side :
         {BoundingSide::server, BoundingSide::client, BoundingSide::both}) {
      const auto p = parameters(mode, side);
      const ServoOptions options = protect_hand(p);
      EXPECT_EQ(options.safety.force.speed < kInfinity, bounding_method(p.mode).admits_reduction);
      EXPECT_NO_THROW(validate(options, p)) << p.mode;
      EXPECT_LT(options.safety.force.small, kInfinity);
    }
}

/// Only a small force of the scene itself may end the wait.
TEST(ServoSafety, OnlyTheScenesOwnSmallForceEndsTheWait) {
  const auto spoilt = [](auto spoil) {
    Reply r = reply(0, {});
    spoil(r);
    return r;
  };
  const Reply not_it[] = {
      spoilt([](Reply& r) { r.bound.active = true; }),     // The server's bound reduced the force.
      spoilt([](Reply& r) { r.bound.saturated = true; }),  // A limit reduced the force.
      spoilt([](Reply& r) { r.bound.refused = true; }),
      spoilt([](Reply& r) { r.command.elastic.x() = kNan; }),
  };
  for (const Reply& nothing : not_it) {
    Bench bench(parameters("none"), {.safety = {.force = {.small = 0.05}}});
    for (int i = 0; i < 10; ++i) bench.tick();  // Ticks without an answer must not end the wait.
    Reply r = nothing;
    r.sample_index = bench.servo.sample().index;
    bench.servo.take(r, bench.now);
    bench.tick();
    bench.servo.take(reply(bench.servo.sample().index, {}), bench.now);
    // After a fault, the position that the reply answered is unknown.
    bench.tick({.pose = {}, .ok = false});
    bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 4)), bench.now);
    EXPECT_EQ(bench.tick().force(), Vec3::Zero());
    EXPECT_EQ(bench.servo.statistics().law.waiting, 1u);
    // This small force must end the wait.
    bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 0.05)), bench.now);
    bench.tick();
    bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 4)), bench.now);
    EXPECT_EQ(bench.tick().force(), Vec3(0, 0, 4));
    EXPECT_EQ(bench.servo.statistics().law.waiting, 1u);
  }
}

TEST(ServoSafety, TheRampCountsFromTheFirstContact) {
  Bench bench(parameters("none"), {.safety = {.ramp_up = 0.01}});
  bench.tick();
  for (int i = 0; i < 100; ++i) {
    bench.servo.take(reply(bench.servo.sample().index, {}), bench.now);
    bench.tick();
  }
  bench.servo.take(reply(bench.servo.sample().index, elastic(0, 0, 5)), bench.now);
  for (int n = 0; n < 20; ++n)
    EXPECT_NEAR(bench.tick().force().z(), 5.0 * std::min(1.0, 0.1 * n), 1e-9) << n;
  EXPECT_NEAR(static_cast<double>(bench.servo.statistics().law.ramped), 10.0, 1.0);
}

}  // namespace
}  // namespace feltwire::servo_safety_test

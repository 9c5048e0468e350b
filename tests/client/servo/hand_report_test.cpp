// Tests a client's report about its hand for observers.

#include "protocol/wire/hand_report.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <set>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::hand_report_test {
namespace {

using namespace testing::servo;

bool says(const Bench& bench, HandReason reason) {
  return (bench.servo.report().reasons & bit(reason)) != 0;
}

/// A servo that got this command as the answer to its first sample.
struct BenchAfterCommand : Bench {
  explicit BenchAfterCommand(const Command& command, std::string_view mode = "none",
                             const ServoOptions& options = {})
      : Bench(parameters(mode), options) {
    tick();
    servo.take(reply(1, command), now);
    tick();
  }
};

const Command kTwo = elastic(0, 0, 2);

TEST(HandReport, SaysNothingOfAHandThatFeelsAll) {
  BenchAfterCommand told(kTwo);
  EXPECT_EQ(told.servo.report().reasons, bit(HandReason::late));
  EXPECT_FALSE(told.servo.report().has_account);
  EXPECT_EQ(BenchAfterCommand({}).servo.report().reasons, 0u);  // no contact
}

TEST(HandReport, SaysWhatTakesForceOff) {
  EXPECT_TRUE(says(BenchAfterCommand(kTwo, "contact_frame"), HandReason::bound));
  ServoOptions limited;
  limited.safety.force.max = 1.0;
  BenchAfterCommand cut(kTwo, "none", limited);
  EXPECT_TRUE(says(cut, HandReason::limits));
  EXPECT_FALSE(says(cut, HandReason::bound));
  EXPECT_TRUE(
      // The device has not dissipated energy yet.
      says(BenchAfterCommand(kTwo, "midpoint"), HandReason::account));
}

/// The report also sets `limits` for older viewers.
TEST(HandReport, NamesTheSafetyLimit) {
  const auto limited = [](const ChannelLimits& force, double ramp_up = 0.0) {
    ServoOptions options;
    options.safety.force = force;
    options.safety.ramp_up = ramp_up;
    return options;
  };
  const auto reasons = [](const Bench& bench) { return bench.servo.report().reasons; };
  const std::uint32_t limits = bit(HandReason::late) | bit(HandReason::limits);
  EXPECT_EQ(reasons(BenchAfterCommand(kTwo, "none", limited({.max = 1.0}))), limits);
  EXPECT_EQ(reasons(BenchAfterCommand(kTwo, "none", limited({}, 1.0))),
            limits | bit(HandReason::ramp));
  EXPECT_EQ(reasons(BenchAfterCommand(kTwo, "none", limited({.slew = 1.0}))),
            limits | bit(HandReason::slew));
  EXPECT_EQ(reasons(BenchAfterCommand(kTwo, "none", limited({.small = 0.05}))),
            limits | bit(HandReason::wait_for_small_force));
  BenchAfterCommand fast(kTwo, "none", limited({.speed = 0.1}));
  for (int i = 1; i < 20; ++i) fast.tick(at(0.002 * i, 0, 0));
  EXPECT_EQ(reasons(fast), limits | bit(HandReason::velocity_limit));
}

/// The hand is deep in a floor. The floor is too stiff for the bound, so the force rises in steps.
TEST(HandReport, NamesTheShaping) {
  SessionParameters shaped = parameters("shaped");
  shaped.local_model = true;
  Bench bench(shaped);
  for (int n = 0; n < 400; ++n) bench.tick(at(0, 0, 0.01 * std::cos(0.05 * n) - 0.03));
  Reply floor = reply(bench.servo.sample().index, elastic(0, 0, 6));
  floor.modelled = true;
  floor.model.reach = 0.1;
  floor.model.count = 1;
  floor.model.patches[0].radius = 0.2;
  floor.model.patches[0].material.stiffness = 200.0;
  bench.servo.take(floor, bench.now);
  bench.tick(at(0, 0, bench.servo.sample().pose.position.z()));
  EXPECT_TRUE(says(bench, HandReason::near));
  EXPECT_TRUE(says(bench, HandReason::bound));
  EXPECT_TRUE(says(bench, HandReason::shaping));
  EXPECT_FALSE(says(bench, HandReason::faded));
  EXPECT_FALSE(says(BenchAfterCommand(kTwo, "contact_frame"), HandReason::shaping));
}

TEST(HandReport, SaysThatTheAccountIsInDebt) {
  BenchAfterCommand told(kTwo, "midpoint");
  for (int n = 1; n < 100; ++n) {
    told.servo.take(reply(told.servo.sample().index, {}), told.now);
    told.tick(surely_at(0.01 * std::sin(0.05 * n), 0, 0));
  }
  told.servo.take(reply(told.servo.sample().index, kTwo), told.now);
  told.tick(surely_at(0, 0, 0));
  ASSERT_GT(told.servo.held().force().z(), 0.1);
  EXPECT_FALSE(says(told, HandReason::debt));
  told.tick(surely_at(0, 0, 0.05),
            from_seconds(0.09));  // The force moved the hand between the ticks.
  EXPECT_LT(told.servo.report().balance, 0.0);
  EXPECT_TRUE(says(told, HandReason::debt));
}

TEST(HandReport, SaysWhyTheDeviceTakesNoForce) {
  BenchAfterCommand told(kTwo);
  const auto reasons = [&](const DeviceReading& reading) {
    told.tick(reading);
    return told.servo.report().reasons;
  };
  EXPECT_EQ(reasons({.pose = {}, .clutched = true}), bit(HandReason::clutched));
  EXPECT_EQ(reasons({.pose = {}, .withheld = Withheld::emergency}), bit(HandReason::emergency));
  for (const Withheld withheld :
       {Withheld::not_homed, Withheld::in_inkwell, Withheld::starting, Withheld::not_moved})
    EXPECT_EQ(reasons({.pose = {}, .withheld = withheld}), bit(HandReason::not_ready));
}

TEST(HandReport, SaysThatTheClientEnds) {
  BenchAfterCommand told(kTwo);
  told.servo.release();
  told.tick();
  EXPECT_TRUE(says(told, HandReason::ending));
  EXPECT_FALSE(says(told, HandReason::reconnecting));
}

TEST(HandReport, HasTheAccountsBalance) {
  BenchAfterCommand told(kTwo, "midpoint");
  ASSERT_TRUE(told.servo.report().has_account);
  EXPECT_EQ(told.servo.report().balance, told.servo.account()->balance());
  const double before = told.servo.report().balance;
  for (int n = 1; n < 50; ++n) told.tick(at(1e-4 * n, 0, 0));
  EXPECT_GT(told.servo.report().balance, before);
}

TEST(HandReport, SaysThatAnOldAnswerFades) {
  BenchAfterCommand told(kTwo);
  told.tick({}, from_seconds(0.08));  // The hold time is 0.1 s.
  EXPECT_TRUE(says(told, HandReason::faded));
  EXPECT_FALSE(says(told, HandReason::reconnecting));
}

TEST(HandReport, SaysThatTheSessionWasLost) {
  BenchAfterCommand told(kTwo);
  told.servo.reconnected(true);
  told.tick();
  EXPECT_TRUE(says(told, HandReason::reconnecting));
  EXPECT_FALSE(says(told, HandReason::faded));
}

TEST(HandReport, SaysThatTheDeviceIsFaulty) {
  BenchAfterCommand told(kTwo);
  DeviceReading none;
  none.ok = false;
  told.tick(none);
  EXPECT_TRUE(says(told, HandReason::device_fault));
}

TEST(HandReport, HasTheRoundTripOfTheNewestAnswer) {
  Bench bench(parameters("none"));
  bench.tick();
  EXPECT_EQ(bench.servo.report().round_trip, 0.0);
  bench.servo.take(reply(1, kTwo), bench.now + from_seconds(0.002));
  EXPECT_NEAR(bench.servo.report().round_trip, 0.002, 1e-9);
}

TEST(HandReport, EveryReasonHasANameOfItsOwn) {
  std::set<std::string_view> names;
  for (const auto& [reason, text] : kHandReasonTexts) {
    EXPECT_TRUE(names.insert(reason).second);
    EXPECT_TRUE(text.ends_with('.'));
  }
}

}  // namespace
}  // namespace feltwire::hand_report_test

// What a client says of its hand to those who look on.

#include "protocol/wire/hand_report.hpp"

#include <gtest/gtest.h>

#include <set>

#include "client/servo/servo.hpp"
#include "tests/client/servo_bench.hpp"

namespace feltwire::hand_report_test {
namespace {

using namespace testing::servo;

bool says(const Bench& bench, HandReason reason) {
  return (bench.servo.report().reasons & bit(reason)) != 0;
}

/// After a first sample that was answered so.
struct Told : Bench {
  explicit Told(const Command& command, std::string_view mode = "none",
                const ServoOptions& options = {})
      : Bench(parameters(mode), options) {
    tick();
    servo.take(reply(1, command), now);
    tick();
  }
};

const Command kTwo = elastic(0, 0, 2);

TEST(HandReport, SaysNothingOfAHandThatFeelsAll) {
  Told told(kTwo);
  EXPECT_EQ(told.servo.report().reasons, bit(HandReason::late));
  EXPECT_FALSE(told.servo.report().has_account);
  EXPECT_EQ(Told({}).servo.report().reasons, 0u);  // touches nothing
}

TEST(HandReport, SaysWhatTakesForceOff) {
  EXPECT_TRUE(says(Told(kTwo, "contact_frame"), HandReason::bound));
  ServoOptions limited;
  limited.safety.force.max = 1.0;
  Told cut(kTwo, "none", limited);
  EXPECT_TRUE(says(cut, HandReason::limits));
  EXPECT_FALSE(says(cut, HandReason::bound));
  EXPECT_TRUE(says(Told(kTwo, "midpoint"), HandReason::account));  // nothing was burned yet
}

TEST(HandReport, HasTheAccountsBalance) {
  Told told(kTwo, "midpoint");
  ASSERT_TRUE(told.servo.report().has_account);
  EXPECT_EQ(told.servo.report().balance, told.servo.account()->balance());
  const double before = told.servo.report().balance;
  for (int n = 1; n < 50; ++n) told.tick(at(1e-4 * n, 0, 0));
  EXPECT_GT(told.servo.report().balance, before);
}

TEST(HandReport, SaysThatAnOldAnswerFades) {
  Told told(kTwo);
  told.tick({}, from_seconds(0.08));  // hold_time is 0.1 s
  EXPECT_TRUE(says(told, HandReason::faded));
  EXPECT_FALSE(says(told, HandReason::reconnecting));
}

TEST(HandReport, SaysThatTheSessionWasLost) {
  Told told(kTwo);
  told.servo.reconnected(true);
  told.tick();
  EXPECT_TRUE(says(told, HandReason::reconnecting));
  EXPECT_FALSE(says(told, HandReason::faded));
}

TEST(HandReport, SaysThatTheDeviceIsFaulty) {
  Told told(kTwo);
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

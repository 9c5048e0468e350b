#include "client/run/status_line.hpp"

#include <gmock/gmock.h>
#include <gtest/gtest.h>

#include "client/run/device_words.hpp"

namespace feltwire::status_line_test {
namespace {

using ::testing::AllOf;
using ::testing::EndsWith;
using ::testing::HasSubstr;
using ::testing::Not;

LiveStatus under_way() {
  return {.time = 12.0,
          .samples = 12'000,
          .network = {.lost = 48,
                      .round_trip_p50 = 123'000.0,
                      .round_trip_p99 = 456'000.0,
                      .clock_known = true,
                      .delay_up = 61e-6,
                      .delay_down = 1.25e-3,
                      .jitter_up = 3e-6,
                      .jitter_down = 40e-6},
          .force = 1.5,
          .no_force = ZeroForceReason::felt,
          .energy = -0.25,
          .answered_lately = true};
}

TEST(StatusLine, SaysWhatTheNetworkDoes) {
  LiveStatus before;
  before.time = 11.0;
  before.samples = 11'000;
  before.network.lost = 40;
  EXPECT_EQ(text(under_way(), before),
            "   12.0 s  1000 Hz  round trip 123/456  up 61+-3  down 1250+-40 us  lost 0.8 %  "
            "force  1.50 N  energy -0.2500 J");
}

TEST(StatusLine, SaysNothingOfWhatIsNotKnown) {
  LiveStatus first;
  EXPECT_THAT(text(first, {}), HasSubstr("up -  down - us"));
  EXPECT_THAT(text(first, {}), HasSubstr("lost 0.0 %"));
  EXPECT_THAT(text(first, {}), EndsWith("  no force: the server has not answered yet"));
}

TEST(StatusLine, SaysThatTheDeviceFailsOrIsSlow) {
  LiveStatus now = under_way();
  EXPECT_THAT(text(now, {}), Not(HasSubstr("device")));
  now.device.faults = 3;
  EXPECT_THAT(text(now, now), HasSubstr("  3 device faults"));
  now.device.faults = now.device.jumps = 1;
  EXPECT_THAT(text(now, now), HasSubstr("  1 device fault (1 jump of its position)"));
  LiveStatus before = now;
  now.device.slow_ticks = 12;
  now.device.took = 0.0204;
  EXPECT_THAT(text(now, before), HasSubstr("  the device is slow: its calls took 20.4 ms"));
  EXPECT_THAT(text(now, now), Not(HasSubstr("slow"))) << "not any more";
}

TEST(DeviceWords, ASlowDeviceGetsARemedy) {
  const auto words = [](std::int64_t read, std::int64_t write, bool paced) {
    DeviceTimes times;
    for (int n = 0; n < 1000; ++n) {
      times.read.record(read);
      times.write.record(write);
    }
    times.read.record(400'000'000);  // A single long call is no fault.
    return slow_device(times, 1e-3, paced);
  };
  EXPECT_EQ(words(2'000, 1'000, false), "");
  EXPECT_EQ(words(400'000, 90'000, false), "");
  EXPECT_THAT(words(20'000'000, 5'000, false),
              AllOf(HasSubstr("read() takes 20."), HasSubstr("--rate 2")));
  EXPECT_THAT(words(5'000, 3'000'000, false),
              AllOf(HasSubstr("write() takes 3.0 ms"), HasSubstr("--rate 16")));
  EXPECT_THAT(words(20'000'000, 5'000, true), Not(HasSubstr("--rate")));
}

TEST(StatusLine, SaysWhetherTheRobotFollows) {
  LiveStatus now = under_way();
  now.robot.state = LinkState::engaged;
  EXPECT_THAT(text(now, {}), HasSubstr("  robot engaged"));
  now.robot.state = LinkState::aligning;
  now.robot.turn = 0.416;
  EXPECT_THAT(text(now, {}), HasSubstr("  robot aligning, turn by 0.42 rad"));
  now.robot.name = "left";
  EXPECT_THAT(text(now, {}), HasSubstr("  robot left aligning, turn by 0.42 rad"));
}

/// The line has the oscillation since the last line and the stiffness of the run. It omits missing
/// measurements.
TEST(StatusLine, SaysHowItFeels) {
  LiveStatus before = under_way(), now = before;
  before.oscillation = {1.0, 1000};
  now.oscillation = {1.0 + 100 * 9e-12, 1100};
  now.displayed_stiffness = 486.6;
  EXPECT_THAT(text(now, before), EndsWith("J  oscillation 3.0 um  stiffness 487 N/m"));
  EXPECT_THAT(text(before, before), Not(HasSubstr("oscillation")));
}

TEST(StatusLine, SaysHowTheForceIsShaped) {
  LiveStatus now = under_way();
  now.shapes = true;
  EXPECT_THAT(text(now, now), EndsWith("J  shaped late"));
  now.hand_credit = HandCredit{.damping = 0.6, .near_share = 0.8512};
  EXPECT_THAT(text(now, now), EndsWith("J  shaped late, 0.60 N s/m of the hand"));
  now.near = true;
  EXPECT_THAT(text(now, now), EndsWith("J  shaped near, 85 % of the force"));
  now.hand_credit->near_share = 0.999;
  EXPECT_THAT(text(now, now), EndsWith("J  shaped near"));
  now.hand_credit->untold_lag = 0.3e-3;
  EXPECT_THAT(text(now, now), EndsWith("J  shaped near, asked 0.30 ms farther ahead"));
  now.hand_credit->near_share = 0.72;
  EXPECT_THAT(text(now, now), EndsWith("near, 72 % of the force, asked 0.30 ms farther ahead"));
}

/// The line has the balance of the energy account. It also has the share of ticks since the last
/// line in which the account reduced the force.
TEST(StatusLine, SaysWhatTheAccountHas) {
  LiveStatus before = under_way(), now = before;
  EXPECT_THAT(text(now, before), Not(HasSubstr("account")));
  before.account.cuts = 400;
  now.account.cuts = 400;
  now.account.balance = 0.012;
  EXPECT_THAT(text(now, before), EndsWith("J  account +0.0120 J"));
  now.samples += 1000;
  now.account.cuts += 340;
  EXPECT_THAT(text(now, before), EndsWith("J  account +0.0120 J, cuts 34 % of the ticks"));
}

/// The line has the share since the last line. The final line has the total.
TEST(StatusLine, SaysThatContactIsCutOff) {
  LiveStatus before = under_way(), now = before;
  before.contact_cuts = now.contact_cuts = 70;
  now.samples += 1000;
  EXPECT_THAT(text(now, before), Not(HasSubstr("contact")));
  now.contact_cuts += 250;
  EXPECT_THAT(text(now, before), EndsWith("J  contact cut off in 25 % of the ticks"));
  ServoStatistics statistics;
  EXPECT_EQ(cut_text(statistics), "");
  statistics.local_model.contact_cut = 12;
  EXPECT_EQ(cut_text(statistics), ", contact cut off in 12 ticks");
}

TEST(StatusLine, SaysWhyThereIsNoForce) {
  LiveStatus status = under_way();
  status.force = 0.0;
  status.no_force = ZeroForceReason::waiting;
  EXPECT_THAT(text(status, {}), EndsWith("  no force: waits: move the hand out of contact first"));
}

TEST(StatusLine, LossIsAShareOfWhatWasSentSince) {
  LiveStatus before = under_way(), now = before;
  now.samples += 10;
  now.network.lost += 400;  // The increase includes older answers that are still in the network.
  EXPECT_THAT(text(now, before), HasSubstr("lost 100.0 %"));
  now.network.lost = before.network.lost - 5;  // Late answers arrived.
  EXPECT_THAT(text(now, before), HasSubstr("lost 0.0 %"));
}

TEST(StatusLine, SaysThatWhatMovesWasPutBack) {
  LiveStatus status = under_way();
  status.scene.recovering = true;
  EXPECT_THAT(text(status, {}), EndsWith("  what moves was put back"));
  status.answered_lately = false;
  EXPECT_THAT(text(status, {}), EndsWith("  no answer"));
}

TEST(StatusLine, SaysThatTheSessionIsLost) {
  LiveStatus status = under_way();
  EXPECT_THAT(text(status, {}), Not(HasSubstr("answer")));
  status.connected = false;
  EXPECT_THAT(text(status, {}), EndsWith("  reconnecting"));
}

}  // namespace
}  // namespace feltwire::status_line_test

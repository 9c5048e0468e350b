// Tests a client's report about its hand in a datagram.

#include <gtest/gtest.h>

#include <limits>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/hand_report.hpp"
#include "tests/protocol/make.hpp"

namespace feltwire::hand_report_codec_test {
namespace {

TEST(HandReportCodec, TravelsWithTheSamples) {
  test::Generator random(12);
  Encoder encoder;
  SampleBatch sent = test::random_batch(random, 9, 3, false);
  sent.report = HandReport{.reasons = bit(HandReason::near) | bit(HandReason::account),
                           .has_account = true,
                           .balance = -0.25,
                           .round_trip = 0.5,
                           .hand_damping = 1.5,
                           .late_ticks = 0xFEDCBA};
  SampleBatch received;
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  ASSERT_TRUE(received.report);
  EXPECT_EQ(received.report->reasons, sent.report->reasons);
  EXPECT_TRUE(received.report->has_account);
  EXPECT_EQ(received.report->balance, -0.25);
  EXPECT_EQ(received.report->round_trip, 0.5);
  EXPECT_EQ(received.report->hand_damping, 1.5);
  EXPECT_EQ(received.report->late_ticks, 0xFEDCBAu);

  sent.report->late_ticks = 0x1000001;  // The wire carries this number modulo 2^24.
  sent.report->has_account = false;
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  EXPECT_EQ(received.report->late_ticks, 1u);
  EXPECT_FALSE(received.report->has_account);

  sent.report->reasons = ~0u;  // A newer client may send unknown reasons, which must be ignored.
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  EXPECT_EQ(received.report->reasons, (1u << kHandReasons) - 1);
  sent.report.reset();
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  EXPECT_FALSE(received.report);

  for (double HandReport::*number :
       {&HandReport::balance, &HandReport::round_trip, &HandReport::hand_damping}) {
    sent.report = HandReport{};
    (*sent.report).*number = std::numeric_limits<double>::quiet_NaN();
    EXPECT_EQ(decode(encoder.samples(sent), received), DropReason::not_finite);
  }
}

TEST(HandReportCodec, TimesTravelWithAReportOnly) {
  test::Generator random(13);
  Encoder encoder;
  SampleBatch sent = test::random_batch(random, 9, 3, false), received;
  sent.report = HandReport{
      .times = HandTimes{.wakeups = {1, 2, 3, 4, 5, 6, 7, 0xFFFF}, .round_trips = {9, 8, 7, 6}}};
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  ASSERT_TRUE(received.report && received.report->times);
  EXPECT_EQ(received.report->times->wakeups, sent.report->times->wakeups);
  EXPECT_EQ(received.report->times->round_trips, sent.report->times->round_trips);

  sent.report->times.reset();
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  ASSERT_TRUE(received.report);
  EXPECT_FALSE(received.report->times);
}

TEST(HandReportCodec, TimesFitIntoTheFullestDatagramOfSamples) {
  constexpr std::size_t kHeaderAndTag = 40;
  test::Generator random(14);
  Encoder encoder;
  SampleBatch sent = test::random_batch(random, 20, kMaxRedundancy + 1, true), received;
  sent.previous = 1;
  sent.lead = Lead{};
  sent.report = HandReport{.times = HandTimes{}};
  const Bytes payload = encoder.samples(sent);
  EXPECT_LE(payload.size() + kHeaderAndTag, kMaxDatagram);
  EXPECT_EQ(decode(payload, received), DropReason::none);
}

TEST(HandTimes, AreCountedUpToTheLimitOfTheirClass) {
  using namespace std::chrono_literals;
  HandTimes::Counts counts{};
  for (const auto time : {0ns, 20'000ns, 20'001ns, 10'000'000ns, 10'000'001ns, 3'600'000'000'000ns})
    count(counts, hand_time_limits::kWakeups, time);
  EXPECT_EQ(counts, (HandTimes::Counts{2, 1, 0, 0, 0, 0, 1, 2}));
}

TEST(HandTimes, AreHeardOverLossAndWrapping) {
  HandTimesHeard heard;
  EXPECT_FALSE(heard.heard());
  HandTimes said;
  said.wakeups[3] = 65'000;  // from an earlier session
  heard.take(said);
  EXPECT_TRUE(heard.heard());
  EXPECT_EQ(heard.wakeups()[3], 0u);
  std::uint64_t counted = 0;
  for (int i = 0; i < 10; ++i) {  // Lost reports in between must have no effect.
    said.wakeups[3] = static_cast<std::uint16_t>(said.wakeups[3] + 60'000);
    ++said.round_trips[7];
    counted += 60'000;
    heard.take(said);
    EXPECT_EQ(heard.wakeups()[3], counted);
  }
  EXPECT_EQ(heard.round_trips()[7], 10u);
  EXPECT_EQ(heard.wakeups()[2], 0u);
}

}  // namespace
}  // namespace feltwire::hand_report_codec_test

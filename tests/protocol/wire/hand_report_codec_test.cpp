// What a client says of its hand, in a datagram.

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

  sent.report->late_ticks = 0x1000001;  // counted modulo 2^24
  sent.report->has_account = false;
  ASSERT_EQ(decode(encoder.samples(sent), received), DropReason::none);
  EXPECT_EQ(received.report->late_ticks, 1u);
  EXPECT_FALSE(received.report->has_account);

  sent.report->reasons = ~0u;  // of a newer client: those that are not known are not read
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

}  // namespace
}  // namespace feltwire::hand_report_codec_test

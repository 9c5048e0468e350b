#include "client/servo/clock_estimate.hpp"

#include <gtest/gtest.h>

#include <cmath>
#include <limits>
#include <random>

namespace feltwire::clock_estimate_test {
namespace {

using std::chrono::microseconds;
using std::chrono::milliseconds;

/// The true server clock. It differs from the client's clock by `offset` and runs fast by `drift`.
struct Truth {
  std::int64_t offset = 0;  // [ns] at client time 0
  double drift = 0.0;       // [s/s]

  Nanoseconds server(double client_time) const {
    return Nanoseconds(offset + std::llround(1e9 * client_time * (1.0 + drift)));
  }
  double offset_at(double t) const { return 1e-9 * static_cast<double>(offset) + drift * t; }
};

Nanoseconds at(double t) { return Nanoseconds(std::llround(1e9 * t)); }

/// Generates random delays [s] with a heavy-tailed distribution.
class Path {
 public:
  Path(double least, double jitter, std::uint64_t seed)
      : least_(least), jitter_(jitter), engine_(seed) {}
  double delay() {
    const double u = (static_cast<double>(engine_() >> 11) + 1.0) * 0x1p-53;
    return least_ + jitter_ * (std::pow(u, -1.0 / 3.0) - 1.0);  // Pareto distribution
  }

 private:
  double least_, jitter_;
  std::mt19937_64 engine_;
};

Exchange exchange(const Truth& truth, double sent, double up, double down) {
  return {at(sent), truth.server(sent + up), truth.server(sent + up), at(sent + up + down)};
}

TEST(ClockEstimate, FindsOffsetAndDriftThroughJitter) {
  const Truth truths[] = {{0, 0.0},
                          {123456789012345, 40e-6},
                          {-9876543210987, -200e-6},
                          {std::numeric_limits<std::int64_t>::max() - 5, 10e-6}};
  for (const Truth& truth : truths) {
    ClockEstimate clock;
    Path up(5e-3, 2e-3, 1), down(5e-3, 4e-3, 2);
    double t = 0.0;
    for (int n = 0; n < 20000; ++n, t += 1e-3) {
      const double delay_up = up.delay(), delay_down = down.delay();
      Exchange e;
      e.sent = at(t);
      e.arrived = at(t + delay_up + delay_down);
      // Unsigned arithmetic lets the server's clock overflow without undefined behaviour.
      e.received = e.answered = Nanoseconds(static_cast<std::int64_t>(
          static_cast<std::uint64_t>(truth.offset) +
          static_cast<std::uint64_t>(std::llround(1e9 * (t + delay_up) * (1.0 + truth.drift)))));
      clock.take(e);
    }
    EXPECT_EQ(clock.restarts(), 0u);
    EXPECT_NEAR(clock.drift(), truth.drift, 5e-6);
    EXPECT_LE(clock.error_bound(), 5.2e-3);
    if (std::abs(truth.offset) < std::int64_t{1} << 60) {
      // The fastest exchanges determine the offset. Its error is therefore far below the jitter.
      EXPECT_NEAR(clock.offset(at(t)), truth.offset_at(t), 100e-6);
      const Nanoseconds back = clock.to_client(truth.server(t));
      EXPECT_NEAR(static_cast<double>((back - at(t)).count()), 0.0, 1e5);
    }
  }
}

TEST(ClockEstimate, APathThatIsSlowerOneWayIsWrongByHalfTheDifferenceAndNoMoreThanTheBound) {
  const Truth truth{1000000, 0.0};
  ClockEstimate clock;
  for (int n = 0; n < 1000; ++n) clock.take(exchange(truth, 1e-3 * n, 8e-3, 2e-3));
  EXPECT_NEAR(clock.offset(at(1.0)) - truth.offset_at(1.0), 3e-3, 1e-9);
  EXPECT_NEAR(clock.error_bound(), 5e-3, 1e-9);
  EXPECT_NEAR(clock.delay_up(), 5e-3, 1e-9);
  EXPECT_NEAR(clock.delay_down(), 5e-3, 1e-9);
}

TEST(ClockEstimate, TheServersOwnTimeIsNoDelay) {
  const Truth truth{5, 0.0};
  ClockEstimate clock;
  Exchange e = exchange(truth, 0.0, 1e-3, 1e-3);
  e.answered += milliseconds(7);
  e.arrived += milliseconds(7);
  clock.take(e);
  EXPECT_NEAR(clock.error_bound(), 1e-3, 1e-9);
  EXPECT_NEAR(clock.delay_up(), 1e-3, 1e-9);
  EXPECT_NEAR(clock.delay_down(), 1e-3, 1e-9);
}

/// The line through old exchanges is extrapolated after an outage, and the path may be another one.
TEST(ClockEstimate, EachWayTakesNoLessThanZeroAndNoMoreThanTheRoundTrip) {
  const Truth truth{0, 30e-6};
  ClockEstimate clock;
  const auto take = [&](double from, double to, double up, double down) {
    for (double t = from; t < to; t += 1e-3) {
      clock.take(exchange(truth, t, up, down));
      for (const double delay : {clock.delay_up(), clock.delay_down()}) {
        ASSERT_GE(delay, 0.0) << t;
        ASSERT_LE(delay, up + down + 1e-9) << t;
      }
    }
  };
  take(0.0, 2.0, 1e-3, 9e-3);
  take(2.0, 4.0, 9e-3, 1e-3);
  take(12.0, 13.0, 0.2e-3, 0.4e-3);
  take(14.0, 15.0, 0.0, 20e-3);
}

TEST(ClockEstimate, JitterIsTheMeanVariationOfTheDelay) {
  const Truth truth{0, 0.0};
  ClockEstimate clock;
  clock.take(exchange(truth, 0.0, 1e-3, 1e-3));  // The fastest exchange determines the offset.
  for (int n = 1; n < 400; ++n) clock.take(exchange(truth, 1e-3 * n, n % 2 ? 2e-3 : 3e-3, 1.5e-3));
  EXPECT_NEAR(clock.jitter_up(), 1e-3, 1e-5);
  EXPECT_NEAR(clock.jitter_down(), 0.0, 1e-5);
}

TEST(ClockEstimate, WhatCannotBeIsLeftOut) {
  ClockEstimate clock;
  clock.take(
      // arrived before it was sent
      {milliseconds(5), milliseconds(0), milliseconds(0), milliseconds(4)});
  clock.take(
      // answered before it was received
      {milliseconds(0), milliseconds(5), milliseconds(4), milliseconds(9)});
  // The server's time exceeds the round trip.
  clock.take({milliseconds(0), milliseconds(0), milliseconds(3), milliseconds(2)});
  clock.take({milliseconds(0), milliseconds(0), milliseconds(0), std::chrono::hours(1)});
  clock.take({Nanoseconds::min(), Nanoseconds::max(), Nanoseconds::min(), Nanoseconds::max()});
  EXPECT_EQ(clock.impossible(), 5u);
  EXPECT_FALSE(clock.known());
  EXPECT_EQ(clock.offset(Nanoseconds{0}), 0.0);
}

TEST(ClockEstimate, AServerThatWasStartedAnewIsANewClock) {
  ClockEstimate clock;
  const Truth before{500000000000, 0.0}, after{1000, 0.0};
  for (int n = 0; n < 3000; ++n) clock.take(exchange(before, 1e-3 * n, 1e-3, 1e-3));
  for (int n = 3000; n < 3100; ++n) clock.take(exchange(after, 1e-3 * n, 1e-3, 1e-3));
  EXPECT_EQ(clock.restarts(), 1u);
  EXPECT_NEAR(clock.offset(at(3.1)), after.offset_at(3.1), 1e-8);
  EXPECT_NEAR(clock.delay_up(), 1e-3, 1e-8);
}

TEST(ClockEstimate, OldBucketsAreForgotten) {
  // The path becomes permanently slower. After the horizon, only the new round trip counts.
  const Truth truth{0, 0.0};
  ClockEstimate clock;
  double t = 0.0;
  for (; t < 5.0; t += 1e-2) clock.take(exchange(truth, t, 1e-3, 1e-3));
  for (; t < 10.0; t += 1e-2) clock.take(exchange(truth, t, 3e-3, 3e-3));
  EXPECT_NEAR(clock.error_bound(), 1e-3, 1e-9);
  for (; t < 25.0; t += 1e-2) clock.take(exchange(truth, t, 3e-3, 3e-3));
  EXPECT_NEAR(clock.error_bound(), 3e-3, 1e-9);
}

}  // namespace
}  // namespace feltwire::clock_estimate_test

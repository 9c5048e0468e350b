#include "client/servo/clock_estimate.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

constexpr double kSecond = 1e-9;           // [s] per nanosecond
constexpr double kLongestExchange = 60.0;  // [s] longest usable exchange
constexpr double kLargestDrift = 500e-6;   // [s/s] RFC 5905: a clock with more drift is unusable
// [s/s] Usual drift of a crystal, assumed before the first measurement.
constexpr double kUsualDrift = 20e-6;
// Least uncertainty of an exchange. Even the fastest exchange waits for the schedulers of both
// machines.
constexpr double kLeastUncertainty = 5e-6;  // [s]
// Least time span of a drift fit. Over a shorter span, the noise of single exchanges hides the
// drift.
constexpr double kDriftTime = 3.0;          // [s]
constexpr double kJitterGain = 1.0 / 16.0;  // gain of the jitter filter (RFC 3550)

/// Returns b - a. Extreme values from a hostile server wrap around and do not overflow.
std::int64_t difference(Nanoseconds a, Nanoseconds b) {
  return static_cast<std::int64_t>(static_cast<std::uint64_t>(b.count()) -
                                   static_cast<std::uint64_t>(a.count()));
}
double in_seconds(std::int64_t nanoseconds) { return kSecond * static_cast<double>(nanoseconds); }

}  // namespace

void ClockEstimate::restart(const Exchange& exchange) noexcept {
  buckets_.fill({});
  buckets_used_ = 0;
  origin_ = exchange.sent;
  base_ = difference(exchange.sent, exchange.received);
  offset_ = drift_ = pivot_ = 0.0;
  jitter_up_ = jitter_down_ = 0.0;
  exchanged_ = false;
}

void ClockEstimate::take(const Exchange& exchange) noexcept {
  const double whole = in_seconds(difference(exchange.sent, exchange.arrived));
  const double at_server = in_seconds(difference(exchange.received, exchange.answered));
  const double round_trip = whole - at_server;
  if (!(at_server >= 0.0) || !(round_trip >= 0.0) || !(whole <= kLongestExchange)) {
    ++impossible_;
    return;
  }
  if (!known()) restart(exchange);

  const auto beyond_base = [&](Nanoseconds client, Nanoseconds server) {
    const auto offset = static_cast<std::uint64_t>(difference(client, server));
    return in_seconds(static_cast<std::int64_t>(offset - static_cast<std::uint64_t>(base_)));
  };
  double up = beyond_base(exchange.sent, exchange.received);
  double down = beyond_base(exchange.arrived, exchange.answered);
  double offset = 0.5 * (up + down);
  double time = in_seconds(difference(origin_, exchange.sent)) + 0.5 * whole;
  // The error of a measured offset is at most half the round trip plus a bounded error from drift.
  // A larger difference shows that the server now uses another clock.
  const double horizon = in_seconds((kBuckets * kBucketTime).count());
  if (known() && std::abs(offset - residual_offset(time)) >
                     0.5 * round_trip + error_bound() + kLargestDrift * horizon) {
    ++restarts_;
    restart(exchange);
    up = beyond_base(exchange.sent, exchange.received);
    down = beyond_base(exchange.arrived, exchange.answered);
    offset = 0.5 * (up + down);
    time = 0.5 * whole;
  }

  const auto number = static_cast<std::int64_t>(time / in_seconds(kBucketTime.count()));
  Fastest& bucket = buckets_[static_cast<std::size_t>(number) % kBuckets];
  if (number < 0 || bucket.bucket > number) return;  // a newer bucket uses this entry
  if (bucket.bucket != number || round_trip < bucket.round_trip) {
    bucket = {number, time, offset, round_trip};
    fit();
  }

  // Limit each delay to the range from zero to the round trip. The fitted offset may give other
  // delays, because it is extrapolated after an outage.
  const double delay_up = std::clamp(up - residual_offset(time), 0.0, round_trip);
  const double delay_down = std::clamp(residual_offset(time) - down, 0.0, round_trip);
  if (exchanged_) {
    jitter_up_ += kJitterGain * (std::abs(delay_up - delay_up_) - jitter_up_);
    jitter_down_ += kJitterGain * (std::abs(delay_down - delay_down_) - jitter_down_);
  }
  exchanged_ = true;
  delay_up_ = delay_up;
  delay_down_ = delay_down;
}

/// Fits offset and drift of the clock by weighted least squares over time.
void ClockEstimate::fit() noexcept {
  std::int64_t newest = -1;
  for (const Fastest& b : buckets_) newest = std::max(newest, b.bucket);
  const auto counts = [&](const Fastest& b) {
    return b.bucket >= 0 && b.bucket > newest - static_cast<std::int64_t>(kBuckets);
  };
  buckets_used_ = 0;
  least_round_trip_ = kLongestExchange;
  double earliest = 0.0, latest = 0.0;
  for (const Fastest& b : buckets_) {
    if (!counts(b)) continue;
    least_round_trip_ = std::min(least_round_trip_, b.round_trip);
    earliest = buckets_used_ == 0 ? b.time : std::min(earliest, b.time);
    latest = buckets_used_ == 0 ? b.time : std::max(latest, b.time);
    ++buckets_used_;
  }
  double slower = 0.0;  // [s] mean excess of the round trips over the fastest round trip
  for (const Fastest& b : buckets_)
    if (counts(b)) slower += (b.round_trip - least_round_trip_) / buckets_used_;
  // A queue in one direction causes the excess over the fastest round trip. Half of this excess is
  // offset error. Even the fastest round trip may contain queueing delay: the mean excess estimates
  // this delay.
  const auto weight = [&](const Fastest& b) {
    const double excess = b.round_trip - least_round_trip_;
    const double uncertainty = kLeastUncertainty + 0.5 * (excess + slower);
    return 1.0 / (uncertainty * uncertainty);
  };
  double sum = 0.0, time = 0.0, offset = 0.0;
  for (const Fastest& b : buckets_) {
    if (!counts(b)) continue;
    const double w = weight(b);
    sum += w;
    time += w * b.time;
    offset += w * b.offset;
  }
  pivot_ = time / sum;
  offset_ = offset / sum;
  drift_ = 0.0;
  if (latest - earliest < kDriftTime) return;
  double squares = 1.0 / (kUsualDrift * kUsualDrift), products = 0.0;
  for (const Fastest& b : buckets_) {
    if (!counts(b)) continue;
    const double w = weight(b), t = b.time - pivot_;
    squares += w * t * t;
    products += w * t * (b.offset - offset_);
  }
  drift_ = std::clamp(products / squares, -kLargestDrift, kLargestDrift);
}

double ClockEstimate::offset(Nanoseconds at) const noexcept {
  if (!known()) return 0.0;
  return in_seconds(base_) + residual_offset(in_seconds(difference(origin_, at)));
}

double ClockEstimate::error_bound() const noexcept {
  return known() ? 0.5 * least_round_trip_ : kLongestExchange;
}

Nanoseconds ClockEstimate::to_client(Nanoseconds server) const noexcept {
  if (!known()) return Nanoseconds{0};
  const Nanoseconds near{static_cast<std::int64_t>(static_cast<std::uint64_t>(server.count()) -
                                                   static_cast<std::uint64_t>(base_))};
  const double rest = residual_offset(in_seconds(difference(origin_, near)));
  return near - Nanoseconds(std::llround(rest / kSecond));
}

}  // namespace feltwire

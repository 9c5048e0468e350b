#pragma once
// Estimates the offset of the server's clock to ours, from the four times of every exchange. It
// reads no clock.

#include <array>
#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// The times of one exchange: a sample leaves (client's clock), is received and answered (server's
/// clock), the reply arrives (client's clock).
struct Exchange {
  Nanoseconds sent{0}, received{0}, answered{0}, arrived{0};
};

/// Offset and drift of the server's clock, by the minimum filter of RFC 5905 section 10: of all
/// exchanges within a bucket of time only the fastest counts, because the delay of a queue is never
/// negative. A line is fitted through the buckets (offset and drift). A bucket with a slower
/// fastest exchange has less weight. All buckets together reach back kBuckets * kBucketTime.
///
/// Such an estimate cannot detect that a path is slower in one direction than in the other. The
/// offset is then wrong by half the difference. `error_bound` limits this error.
class ClockEstimate {
 public:
  static constexpr std::size_t kBuckets = 32;
  static constexpr Nanoseconds kBucketTime = std::chrono::milliseconds(500);

  /// Takes an exchange. An impossible one (a negative time, or more than a minute) is ignored and
  /// counted. If the server's clock jumped (it was restarted), a new estimate begins.
  void take(const Exchange& exchange) noexcept;

  bool known() const noexcept { return buckets_used_ > 0; }
  /// [s] The server's clock less ours at our time `at`; zero while unknown. Clocks have any origin,
  /// so this may be any number: to_client() uses it.
  double offset(Nanoseconds at) const noexcept;
  double drift() const noexcept { return drift_; }  // [s/s] of the server's clock against ours
  /// [s] The error of the offset is at most this if each direction had the least delay once: half
  /// the fastest round trip.
  double error_bound() const noexcept;
  /// Our time at which the server's clock showed `server`.
  Nanoseconds to_client(Nanoseconds server) const noexcept;

  /// [s] The delays of the last exchange, by this estimate: to the server, and back.
  double delay_up() const noexcept { return delay_up_; }
  double delay_down() const noexcept { return delay_down_; }
  /// [s] mean variation of the delay from one exchange to the next, RFC 3550 section 6.4.1.
  double jitter_up() const noexcept { return jitter_up_; }
  double jitter_down() const noexcept { return jitter_down_; }

  std::uint64_t impossible() const noexcept { return impossible_; }
  std::uint64_t restarts() const noexcept { return restarts_; }

 private:
  /// The fastest exchange of a bucket.
  struct Fastest {
    std::int64_t bucket = -1;  // number since the first exchange
    double time = 0.0;         // [s] since the first exchange, our clock, its middle
    double offset = 0.0;       // [s] beyond base_
    double round_trip = 0.0;   // [s] without the server's own time
  };
  void restart(const Exchange& exchange) noexcept;
  void fit() noexcept;
  double residual_offset(double time) const noexcept { return offset_ + drift_ * (time - pivot_); }

  std::array<Fastest, kBuckets> buckets_{};
  int buckets_used_ = 0;
  Nanoseconds origin_{0};  // our time of the first exchange
  std::int64_t base_ = 0;  // [ns] offset of the first exchange: the rest is small enough for double
  double pivot_ = 0.0, offset_ = 0.0, drift_ = 0.0;
  double least_round_trip_ = 0.0;
  double delay_up_ = 0.0, delay_down_ = 0.0, jitter_up_ = 0.0, jitter_down_ = 0.0;
  bool exchanged_ = false;
  std::uint64_t impossible_ = 0, restarts_ = 0;
};

}  // namespace feltwire

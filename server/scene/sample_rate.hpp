#pragma once
// Limits the samples of a session, by the server's clock, which is an argument.

#include "core/base/token_bucket.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A session with servo period T [s] and `share` a may send r = a / T samples a second and r at
/// once, the number that a network may hold back for a second; further samples are dropped. A
/// session that sends 2 r a second and 2 r at once, dropped ones counted, is flooding: at 4 r after
/// one second.
class SampleRate {
 public:
  SampleRate(double servo_period, double share) noexcept
      : granted_(of_rate(share / servo_period)), tolerated_(of_rate(2.0 * share / servo_period)) {}

  /// A datagram of this session has come; false if it is one too many.
  bool admit(Nanoseconds now) noexcept {
    flooding_ = flooding_ || !tolerated_.take(now);
    return granted_.take(now) && !flooding_;
  }
  /// It contained so many new samples, not one.
  void count(std::uint64_t samples) noexcept {
    const double more = static_cast<double>(samples) - 1.0;
    granted_.charge(more);
    tolerated_.charge(more);
  }
  /// True for good after the first moment of flooding.
  bool flooding() const noexcept { return flooding_; }

 private:
  /// A bucket with the tokens of one second.
  static TokenBucket of_rate(double rate) noexcept { return {rate, rate}; }

  TokenBucket granted_, tolerated_;
  bool flooding_ = false;
};

}  // namespace feltwire

#pragma once
// How many samples a session may send: token buckets (RFC 2697) on the server's clock, which is an
// argument.

#include <algorithm>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Fills at `rate` up to what `rate` gives in `depth` [s], and begins full.
class TokenBucket {
 public:
  TokenBucket(double rate, double depth) noexcept
      : rate_(rate), most_(rate * depth), tokens_(most_) {}

  /// Whether there is one; takes it then. A clock that runs back fills nothing.
  bool take(Nanoseconds now) noexcept {
    if (now > last_) {
      // Before the first there is no time to count from; the bucket is full anyway.
      tokens_ = std::min(most_, tokens_ + rate_ * seconds(now - last_));
    }
    last_ = now;
    if (tokens_ < 1.0) return false;
    tokens_ -= 1.0;
    return true;
  }
  /// Takes more, though it run into debt.
  void charge(double tokens) noexcept { tokens_ -= tokens; }

 private:
  double rate_, most_, tokens_;  // [1/s], [1], [1]
  Nanoseconds last_{0};
};

/// A session with servo period T [s] and `share` a may send r = a / T samples a second and r at
/// once, which is what a network holds back for a second and lets go; what is more is dropped. Who
/// sends 2 r a second and 2 r at once, dropped ones counted, is flooding: at 4 r after one second.
class SampleRate {
 public:
  SampleRate(double servo_period, double share) noexcept
      : granted_(share / servo_period, kDepth), tolerated_(2.0 * share / servo_period, kDepth) {}

  /// A datagram of this session has come; false where it is one too many.
  bool admit(Nanoseconds now) noexcept {
    flooding_ = flooding_ || !tolerated_.take(now);
    return granted_.take(now) && !flooding_;
  }
  /// It brought so many new samples, not one.
  void count(std::uint64_t samples) noexcept {
    const double more = static_cast<double>(samples) - 1.0;
    granted_.charge(more);
    tolerated_.charge(more);
  }
  /// From the first moment on that it was, for good.
  bool flooding() const noexcept { return flooding_; }

 private:
  static constexpr double kDepth = 1.0;  // [s]
  TokenBucket granted_, tolerated_;
  bool flooding_ = false;
};

}  // namespace feltwire

#pragma once

#include <algorithm>
#include <chrono>

namespace feltwire {

/// How often something may be done (RFC 2697): tokens come at `rate`, so many as `most` are kept,
/// and a bucket begins full. No clock: time is an argument.
class TokenBucket {
 public:
  using Time = std::chrono::nanoseconds;

  TokenBucket(double rate, double most) noexcept : rate_(rate), most_(most), tokens_(most) {}

  /// Whether there is one; takes it then. A clock that runs back fills nothing.
  bool take(Time now) noexcept {
    tokens_ = tokens_at(now);
    last_ = now;
    if (tokens_ < 1.0) return false;
    tokens_ -= 1.0;
    return true;
  }
  /// Takes more, though it run into debt.
  void charge(double tokens) noexcept { tokens_ -= tokens; }
  /// Whether it allows what a new one would.
  bool is_full(Time now) const noexcept { return tokens_at(now) >= most_; }

 private:
  /// Before the first taking there is no time to count from; the bucket is full anyway.
  double tokens_at(Time now) const noexcept {
    if (now <= last_) return tokens_;
    const double passed = std::chrono::duration<double>(now - last_).count();
    return std::min(most_, tokens_ + rate_ * passed);
  }

  double rate_, most_, tokens_;  // [1/s], [1], [1]
  Time last_{0};
};

}  // namespace feltwire

#pragma once

#include <algorithm>
#include <chrono>

namespace feltwire {

/// Limits how often an action may be done (RFC 2697). Tokens arrive at `rate`, at most `most` are
/// kept, and a bucket begins full. It has no clock: time is an argument.
class TokenBucket {
 public:
  using Time = std::chrono::nanoseconds;

  TokenBucket(double rate, double most) noexcept : rate_(rate), most_(most), tokens_(most) {}

  /// Takes a token if there is one, and returns whether there was. A clock that runs back adds
  /// none.
  bool take(Time now) noexcept {
    tokens_ = tokens_at(now);
    last_ = now;
    if (tokens_ < 1.0) return false;
    tokens_ -= 1.0;
    return true;
  }
  /// Whether take() would take one now.
  bool has_one(Time now) const noexcept { return tokens_at(now) >= 1.0; }
  /// Takes more tokens, even if that makes a debt.
  void charge(double tokens) noexcept { tokens_ -= tokens; }
  /// Whether it is as full as a new one.
  bool is_full(Time now) const noexcept { return tokens_at(now) >= most_; }

 private:
  /// Before the first token is taken there is no start time; the bucket is full anyway.
  double tokens_at(Time now) const noexcept {
    if (now <= last_) return tokens_;
    const double passed = std::chrono::duration<double>(now - last_).count();
    return std::min(most_, tokens_ + rate_ * passed);
  }

  double rate_, most_, tokens_;  // [1/s], [1], [1]
  Time last_{0};
};

}  // namespace feltwire

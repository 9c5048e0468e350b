#pragma once

#include <array>
#include <cstdint>
#include <set>
#include <utility>

#include "core/base/time.hpp"

namespace feltwire {

/// Remembers what was used once, for `period` at least and twice that at most, in bounded memory:
/// two sets, of which the older is dropped as a whole. It has no clock.
class ReplayCache {
 public:
  using Nonce = std::array<std::uint8_t, 16>;

  enum class Use {
    first,
    again,
    full,  // no room to remember it: it must not be used
  };

  /// `capacity` is for each of the two sets. A nonce takes some 64 bytes.
  ReplayCache(Nanoseconds period, std::size_t capacity) : period_(period), capacity_(capacity) {}

  /// `now` never runs back.
  Use use(const Nonce& nonce, Nanoseconds now) {
    if (now - begun_ >= period_) {
      // After two periods nothing of the current set is needed either.
      older_ = now - begun_ < 2 * period_ ? std::exchange(current_, {}) : Nonces{};
      current_.clear();
      begun_ = now;
    }
    if (current_.contains(nonce) || older_.contains(nonce)) return Use::again;
    if (current_.size() >= capacity_) return Use::full;
    current_.insert(nonce);
    return Use::first;
  }

  std::size_t size() const noexcept { return current_.size() + older_.size(); }

 private:
  using Nonces = std::set<Nonce>;

  Nanoseconds period_;
  std::size_t capacity_;
  Nanoseconds begun_{0};
  Nonces current_, older_;
};

}  // namespace feltwire

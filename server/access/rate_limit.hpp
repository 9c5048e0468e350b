#pragma once
// How often somebody may do something.

#include <map>

#include "core/base/token_bucket.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A token bucket for each key (a network, a client's name). Remembers at most kMost keys; those
/// beyond share one bucket.
template <class Key>
class RateLimit {
 public:
  static constexpr std::size_t kMost = 4096;

  /// `rate` [1/s] for ever, `burst` at once.
  RateLimit(double rate, double burst) : new_(rate, burst), shared_(new_) {}

  /// Whether one more is allowed; counts it then. `now` never falls.
  bool take(const Key& key, Nanoseconds now) {
    auto found = buckets_.find(key);
    if (found == buckets_.end()) {
      if (buckets_.size() >= kMost)
        // A full bucket says no more than none.
        std::erase_if(buckets_, [&](const auto& entry) { return entry.second.is_full(now); });
      if (buckets_.size() >= kMost) return shared_.take(now);
      found = buckets_.emplace(key, new_).first;
    }
    return found->second.take(now);
  }

 private:
  TokenBucket new_;  // of a key that is not remembered
  TokenBucket shared_;
  std::map<Key, TokenBucket> buckets_;
};

}  // namespace feltwire

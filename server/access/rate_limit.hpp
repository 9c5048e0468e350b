#pragma once
// Limits how often a client may do something.

#include <map>

#include "core/base/token_bucket.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A token bucket for each key (a network, a client's name). It remembers at most kMost keys; all
/// others share one bucket.
template <class Key>
class RateLimit {
 public:
  static constexpr std::size_t kMost = 4096;

  /// `rate` [1/s] sustained, `burst` at once.
  RateLimit(double rate, double burst) : new_(rate, burst), shared_(new_) {}

  /// Returns whether one more is allowed, and counts it then. `now` never falls.
  bool take(const Key& key, Nanoseconds now) {
    auto found = buckets_.find(key);
    if (found == buckets_.end()) {
      if (buckets_.size() >= kMost)
        // A full bucket is the same as a missing one.
        std::erase_if(buckets_, [&](const auto& entry) { return entry.second.is_full(now); });
      if (buckets_.size() >= kMost) return shared_.take(now);
      found = buckets_.emplace(key, new_).first;
    }
    return found->second.take(now);
  }

 private:
  TokenBucket new_;  // of a key without a bucket
  TokenBucket shared_;
  std::map<Key, TokenBucket> buckets_;
};

}  // namespace feltwire

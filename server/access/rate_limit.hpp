#pragma once
// How often somebody may do something.

#include <algorithm>
#include <chrono>
#include <map>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A token bucket for each key (a network, a client's name). Remembers at most kMost keys; those
/// beyond share one bucket.
template <class Key>
class RateLimit {
 public:
  static constexpr std::size_t kMost = 4096;

  /// `rate` [1/s] for ever, `burst` at once.
  RateLimit(double rate, double burst) : rate_(rate), burst_(burst), shared_{burst, {}} {}

  /// Whether one more is allowed; counts it then. `now` never falls.
  bool take(const Key& key, Nanoseconds now) {
    Bucket& found = bucket(key, now);
    if (found.left < 1.0) return false;
    found.left -= 1.0;
    return true;
  }

 private:
  struct Bucket {
    double left;
    Nanoseconds at;
  };

  void fill(Bucket& bucket, Nanoseconds now) const {
    const double elapsed = std::chrono::duration<double>(now - bucket.at).count();
    bucket.left = std::min(burst_, bucket.left + rate_ * std::max(0.0, elapsed));
    bucket.at = now;
  }

  Bucket& bucket(const Key& key, Nanoseconds now) {
    auto found = buckets_.find(key);
    if (found == buckets_.end()) {
      if (buckets_.size() >= kMost)
        // A full bucket says no more than none.
        std::erase_if(buckets_, [&](const auto& entry) {
          Bucket filled = entry.second;
          fill(filled, now);
          return filled.left >= burst_;
        });
      if (buckets_.size() >= kMost) {
        fill(shared_, now);
        return shared_;
      }
      found = buckets_.emplace(key, Bucket{burst_, now}).first;
    }
    fill(found->second, now);
    return found->second;
  }

  double rate_, burst_;
  std::map<Key, Bucket> buckets_;
  Bucket shared_;
};

}  // namespace feltwire

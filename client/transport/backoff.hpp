#pragma once

#include <algorithm>
#include <chrono>
#include <cstdint>
#include <random>

#include "core/base/splitmix.hpp"

namespace feltwire {

/// A number of the system's randomness.
inline std::uint64_t random_seed() {
  std::random_device random;
  constexpr int kHalf = 32;  // [bits]
  return (std::uint64_t{random()} << kHalf) | random();
}

/// The waits before attempts at a server that does not answer. Each is drawn at random, from zero
/// to a limit that doubles up to the longest: RFC 8085 asks for care, and clients that lose their
/// sessions at once must not come back at once (full jitter; M. Brooker: Exponential backoff and
/// jitter, AWS Architecture Blog, 2015).
class Backoff {
 public:
  /// `seed`: of the draws; two clients need different ones.
  Backoff(std::chrono::milliseconds first, std::chrono::milliseconds longest, std::uint64_t seed)
      : first_(first), longest_(longest), limit_(first), seed_(seed) {}

  /// The next wait.
  std::chrono::milliseconds next() noexcept {
    const auto choices = static_cast<std::uint64_t>(std::max<std::int64_t>(limit_.count(), 0)) + 1;
    limit_ = std::min(2 * limit_, longest_);
    return std::chrono::milliseconds(splitmix::draw(seed_, draws_++) % choices);
  }
  /// After a success: the limit is the first one again.
  void reset() noexcept { limit_ = first_; }

 private:
  std::chrono::milliseconds first_, longest_, limit_;
  std::uint64_t seed_, draws_ = 0;
};

}  // namespace feltwire

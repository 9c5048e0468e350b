#pragma once
// The clock of those who wait; whatever computes is told the time.

#include <chrono>

#include "protocol/datagram.hpp"

namespace feltwire {

/// Time of a clock that never goes back; it counts from anywhere.
inline Nanoseconds monotonic_now() noexcept {
  return std::chrono::duration_cast<Nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch());
}

}  // namespace feltwire

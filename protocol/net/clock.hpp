#pragma once

#include <chrono>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// This machine's monotonic clock (CLOCK_MONOTONIC), for the programs' outermost loops: read once a
/// wake-up, everything else is told the time.
inline Nanoseconds monotonic_now() noexcept {
  return std::chrono::duration_cast<Nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch());
}

}  // namespace feltwire

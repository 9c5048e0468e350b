#pragma once

#include <chrono>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// This machine's monotonic clock (CLOCK_MONOTONIC), for the outermost loops of the programs: they
/// read it once a wake-up, and pass the time to all other code.
inline Nanoseconds monotonic_now() noexcept {
  return std::chrono::duration_cast<Nanoseconds>(
      std::chrono::steady_clock::now().time_since_epoch());
}

/// [ns] difference between that clock and the time since 1970, now.
inline std::int64_t clock_offset() {
  const auto since_1970 = std::chrono::system_clock::now().time_since_epoch();
  return (std::chrono::duration_cast<Nanoseconds>(since_1970) - monotonic_now()).count();
}

}  // namespace feltwire

#pragma once

#include <cstdint>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// Returns the time [s] between two times of a client's clock. A hostile client may send any time,
/// so the difference is computed without overflow: it wraps around.
inline double seconds_between(Nanoseconds earlier, Nanoseconds later) noexcept {
  const auto difference =
      static_cast<std::uint64_t>(later.count()) - static_cast<std::uint64_t>(earlier.count());
  return 1e-9 * static_cast<double>(static_cast<std::int64_t>(difference));
}

}  // namespace feltwire

#pragma once

#include <cstdint>

#include "server/scene/slow_down.hpp"

namespace feltwire {

/// The limits of a session. Beyond them it is slowed or ended.
struct SessionLimits {
  static constexpr double kSampleRate = 1.5;
  double sample_rate =
      kSampleRate;  // as a multiple of its servo rate, > 1 (server/scene/sample_rate.hpp)
  /// Datagrams under its id that were not sealed with its keys; never more than the cipher allows
  /// (forgery_limit).
  std::uint64_t forgeries = ~std::uint64_t{0};
  /// The sessions that are slowed down while the scene's thread is short of time, and their order.
  SlowDownOrder slow_down = {Slowed::observers, Slowed::hands};
  /// Resets of moving objects for which its hand may be blamed: so many at once, and again within
  /// the time [s]; with one more the session ends.
  static constexpr int kResets = 5;
  static constexpr double kResetTime = 10.0;
};

}  // namespace feltwire

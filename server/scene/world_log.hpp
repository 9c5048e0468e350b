#pragma once
// Log lines about the moving objects of a scene. It has no clock: time is an argument.

#include <string>
#include <vector>

#include "core/dynamics/world.hpp"
#include "server/scene/log_limit.hpp"

namespace feltwire {

/// The totals of a world and its scene since they began.
struct WorldNews {
  WorldCounters counters = {};
  std::uint64_t ticks_dropped = 0;
  double tick = 0.0;  // [s]
};

class WorldLog {
 public:
  /// The lines that are due now, mostly none. Of each kind there is at most one a second; dropped
  /// ticks and warnings of MuJoCo are repeated only when their number has doubled.
  std::vector<std::string> lines(const WorldNews& news, Nanoseconds now);

  /// The scene has another world from now on, whose counters begin at zero.
  void begin_anew() noexcept;

 private:
  std::uint64_t resets_ = 0;  // of this world, seen so far
  LogLimit reset_lines_;
  DoublingLimit dropped_lines_, warning_lines_;
};

}  // namespace feltwire

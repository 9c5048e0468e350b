#pragma once
// What the log says of what moves in a scene. No clock: time is an argument.

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
  /// The lines that are due now, mostly none. Of each kind there is at most one a second, however
  /// often it happens; dropped ticks and warnings of MuJoCo are told when there are twice as many.
  std::vector<std::string> lines(const WorldNews& news, Nanoseconds now);

  /// The scene has another world from now on, whose counters begin at zero.
  void begin_anew() noexcept;

 private:
  std::uint64_t resets_ = 0;  // of this world, seen so far
  LogLimit reset_lines_;
  DoublingLimit dropped_lines_, warning_lines_;
};

}  // namespace feltwire

#pragma once
// A sweep of identify, and its recorded ticks.

#include <cstddef>
#include <vector>

#include "core/base/types.hpp"

namespace feltwire {

/// A movement to and fro along a line at constant speed, with soft turns at both ends.
struct Sweep {
  Vec3 along = Vec3::UnitX();  // unit, world frame
  double speed = 0.0;          // [m/s] between the turns
  int cycles = 1;              // measured cycles; one more comes before them
  double shake = 0.0;          // [Hz] of a force along it that shakes the handle; 0: none
};

/// A tick.
struct SweepTick {
  double time = 0.0;             // [s] of the reading
  Vec3 position = Vec3::Zero();  // [m] as read
  Vec3 force = Vec3::Zero();     // [N] held from this reading to the next
};

struct SweepRecord {
  Sweep sweep;
  std::vector<SweepTick> ticks;
  std::vector<std::size_t> turns;  // ticks at which a measured cycle begins, and the last one's end
};

}  // namespace feltwire

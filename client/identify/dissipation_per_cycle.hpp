#pragma once
// The energy that a device takes in the cycles of a sweep, and the line through several speeds.

#include <span>
#include <vector>

#include "client/identify/sweep_record.hpp"

namespace feltwire {

/// A closed cycle.
struct DissipationCycle {
  double resistance = 0.0;  // [N] work over length
  double speed = 0.0;       // [m/s] mean along the way
  double slow_share = 0.0;  // share of the path slower than kSlow, where stiction may act
};

inline constexpr double kSlow = 0.04;  // [m/s]

/// `delay` [s] of the readings after the forces; `mass` [kg] corrects for the difference of the
/// speeds at the cycle's ends.
std::vector<DissipationCycle> dissipation_per_cycle(const SweepRecord& run, double delay,
                                                    double mass);

/// [N/m] stiffness with which the handle returns to a place along the sweep, over its whole cycles.
double pull_back(const SweepRecord& run);

/// y = offset + slope x, with standard errors.
struct FittedLine {
  double slope = 0.0, slope_error = 0.0, offset = 0.0, offset_error = 0.0;
  int freedom = 0;  // points less two
};
FittedLine fitted_line(std::span<const DissipationCycle> cycles);

/// Student's t of one side, of 99.9 %.
double student(int freedom);

/// [m/s] the mean velocity about tick k, over `half` ticks before and after.
/// Precondition: half <= k < ticks - half.
Vec3 velocity_at(std::span<const SweepTick> ticks, std::size_t k, std::size_t half);
inline constexpr std::size_t kHalfWindow =
    5;  // [ticks] longer than a controller's filter remembers

}  // namespace feltwire

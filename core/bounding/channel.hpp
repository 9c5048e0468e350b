#pragma once
// Law (C) of one channel of the contact-frame bound.

#include <algorithm>
#include <cmath>

#include "core/numeric.hpp"

namespace feltwire {

/// c = 2 b / T [N/m], and T itself for holds that last longer.
struct ChannelLaw {
  double c = 0.0;
  double period = 1e-3;  // [s]
};

/// Energy E that a channel delivered beyond its budget during an overlong hold, kept as the force sqrt(4 b E / T) [N]
/// whose storage S it is, so that no square can overflow. Repaid from the budget before any force.
struct Debt {
  double force = 0.0;  // [N]
};

/// sqrt(a^2 - b^2) for a >= b >= 0 without overflow or cancellation.
inline double root_difference(double a, double b) noexcept { return std::sqrt(a - b) * std::sqrt(a + b); }

/// The largest magnitude that the channel may hold next.
///
/// (C) in energies, times 4 b / T, for a force held h >= T while the channel moved dx_ch (paper's sign F = -f):
///   |F(n)|^2 <= |F(n-1) + c dx_ch|^2 + 2 c F(n-1).dx_foreign - c^2 |dx_ch|^2 (1 - T/h) - debt^2
/// The damping credit is (b/h) |dx_ch|^2, what the device really burned in the real time. `dx_foreign` is motion that
/// belongs to the other channel's damping but that the held force did work on all the same.
///
/// Arguments: `moved` = |F(n-1) + c dx_ch| [N]; `foreign` = 2 c F(n-1).dx_foreign [N^2]; `travel` = c |dx_ch| [N];
/// `hold_time` >= T [s]. A negative budget becomes debt and allows nothing.
inline double allowed_magnitude(double moved, double foreign, double travel, double hold_time, const ChannelLaw& law,
                                Debt& debt) noexcept {
  double owed = debt.force;
  if (hold_time > law.period) owed = std::hypot(owed, travel * std::sqrt(1.0 - law.period / hold_time));
  if (foreign < 0.0) owed = std::hypot(owed, std::sqrt(-foreign));
  if (foreign > 0.0) moved = std::hypot(moved, std::sqrt(foreign));
  if (moved >= owed) [[likely]] {
    debt.force = 0.0;
    return owed > 0.0 ? root_difference(moved, owed) : moved;
  }
  debt.force = root_difference(owed, moved);
  return 0.0;
}

}  // namespace feltwire

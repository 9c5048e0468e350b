#pragma once
// Law (C) of one channel of the contact-frame bound, and what happens when nature broke it.

#include <algorithm>
#include <cmath>

#include "core/numeric.hpp"

namespace feltwire {

/// c = 2 b / T [N/m], and T itself for holds that last longer.
struct ChannelLaw {
  double c = 0.0;
  double period = 1e-3;  // [s]
};

/// sqrt(a^2 - b^2) for a >= b >= 0 without overflow or cancellation.
inline double root_difference(double a, double b) noexcept {
  return b > 0.0 ? std::sqrt(a - b) * std::sqrt(a + b) : a;
}

/// Energy E that a port delivered beyond its budget: a hold that lasted longer than T, or a force
/// held that was never allowed. Kept as the force sqrt(4 b E / T) [N] whose storage it is, so that
/// no square can overflow.
struct Debt {
  double force = 0.0;  // [N]

  void add(double more) noexcept { force = hypotenuse(force, more); }

  /// Repays from what a channel would be allowed; returns what that leaves to the channel. No force
  /// before all is repaid.
  double repay(double allowed) noexcept {
    if (allowed < force) {
      force = root_difference(force, allowed);
      return 0.0;
    }
    const double left = root_difference(allowed, force);
    force = 0.0;
    return left;
  }
};

/// The largest magnitude that a channel may hold next, debts apart.
///
/// (C) in energies, times 4 b / T, for a force held h >= T while the channel moved dx_ch (paper's
/// sign F = -f):
///   |F(n)|^2 <= |F(n-1) + c dx_ch|^2 - c^2 |dx_ch|^2 (1 - T/h)
/// The damping credit is (b/h) |dx_ch|^2, what the device really burned at least in the real time.
/// Only for h > T can this be negative; then it is a debt.
///
/// Arguments: `moved` = |F(n-1) + c dx_ch| [N]; `travel` = c |dx_ch| [N]; `hold_time` >= T [s].
inline double allowed_magnitude(double moved, double travel, double hold_time,
                                const ChannelLaw& law, Debt& debt) noexcept {
  if (!(hold_time > law.period)) [[likely]]
    return moved;
  const double unburned = travel * std::sqrt(1.0 - law.period / hold_time);
  if (moved >= unburned) return root_difference(moved, unburned);
  debt.add(root_difference(unburned, moved));
  return 0.0;
}

/// What a force that was held has beyond what was allowed: the storage that it takes the place of
/// is smaller than its own.
inline double excess(double held, double allowed) noexcept {
  // Splitting a held force into its channels again rounds by some ulps; that is no excess.
  constexpr double kRounding = 1e-15;
  return held > allowed * (1.0 + kRounding) ? root_difference(held, allowed) : 0.0;
}

}  // namespace feltwire

#pragma once
// Law (C) of one channel of the contact-frame bound, and the debt of a channel that broke it.

#include <algorithm>
#include <cmath>
#include <limits>

#include "core/base/numeric.hpp"

namespace feltwire {

/// c = 2 b / T [N/m], and T, which is needed for holds that last longer.
template <class Real>
struct ChannelLaw {
  Real c = 0;
  Real period = Real(1e-3);  // [s]
};

/// sqrt(a^2 - b^2) for a >= b >= 0 without overflow or cancellation.
template <class Real>
inline Real root_difference(Real a, Real b) noexcept {
  return b > 0 ? std::sqrt(a - b) * std::sqrt(a + b) : a;
}

/// The energy E that a port delivered beyond its budget, because a hold lasted longer than T or a
/// force was held that the bound had not allowed. It is stored as the force sqrt(4 b E / T) [N]
/// whose storage is E, so that no square can overflow.
template <class Real>
struct Debt {
  Real force = 0;  // [N]

  void add(Real more) noexcept {
    if (more > 0) force = hypotenuse(force, more);
  }

  /// Repays the debt from the force that a channel would be allowed, and returns the rest. The rest
  /// is zero until the whole debt is repaid.
  Real repay(Real allowed) noexcept {
    if (allowed < force) {
      force = root_difference(force, allowed);
      return 0;
    }
    const Real left = root_difference(allowed, force);
    force = 0;
    return left;
  }
};

/// The largest magnitude that a channel may hold next, without regard to debts.
///
/// (C) in energies, times 4 b / T, for a force held h >= T while the channel moved dx_ch (paper's
/// sign F = -f):
///   |F(n)|^2 <= |F(n-1) + c dx_ch|^2 - c^2 |dx_ch|^2 (1 - T/h)
/// The damping credit is (b/h) |dx_ch|^2, the least energy that the device burned in the real time.
/// The right side can be negative only for h > T; then it is a debt.
///
/// Arguments: `moved` = |F(n-1) + c dx_ch| [N]; `distance` gives |dx_ch| [m]; `hold_time` >= T [s].
template <class Real, class Distance>
inline Real allowed_magnitude(Real moved, const Distance& distance, Real hold_time,
                              const ChannelLaw<Real>& law, Debt<Real>& debt) noexcept {
  if (!(hold_time > law.period)) [[likely]]
    return moved;
  const Real unburned = law.c * distance() * std::sqrt(1 - law.period / hold_time);
  if (moved >= unburned) return root_difference(moved, unburned);
  debt.add(root_difference(unburned, moved));
  return 0;
}

/// The excess of a held force over the allowed one, as a debt: the held force has a larger storage
/// than the allowed one that it replaced.
template <class Real>
inline Real excess(Real held, Real allowed) noexcept {
  // Splitting a held force into its channels rounds by some ulps. That is not an excess.
  constexpr Real kRounding = 5 * std::numeric_limits<Real>::epsilon();
  return held > allowed * (1 + kRounding) ? root_difference(held, allowed) : Real(0);
}

}  // namespace feltwire

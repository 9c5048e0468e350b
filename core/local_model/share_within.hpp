#pragma once

namespace feltwire {

/// The outer share of a reach or a radius, in which the weight of a model falls linearly to zero.
inline constexpr double kHandOver = 0.25;

/// 1 up to the last share of `limit`, then linearly to 0 at it and beyond. NaN gives 0.
inline double share_within(double distance, double limit) noexcept {
  if (!(distance < limit)) return 0.0;
  const double full = (1.0 - kHandOver) * limit;
  return distance <= full ? 1.0 : (limit - distance) / (limit - full);
}

}  // namespace feltwire

#pragma once
// The movement of the hand of a task from place to place.

#include <algorithm>

namespace feltwire::teleop {

/// From a to b within the time [from, until], without a jerk at either end (minimum jerk).
inline double minimum_jerk(double a, double b, double from, double until, double t) {
  constexpr double kFirst = 10.0, kSecond = 15.0, kThird = 6.0;
  const double u = std::clamp((t - from) / (until - from), 0.0, 1.0);
  return a + (b - a) * u * u * u * (kFirst - u * (kSecond - u * kThird));
}

/// From 0 to 1.
inline double eased(double from, double until, double t) {
  return minimum_jerk(0.0, 1.0, from, until, t);
}

}  // namespace feltwire::teleop

#pragma once
// Shared by the tests of the account: a handle, samples of it, and a need found by
// search.

#include "core/bounding/account.hpp"
#include "tests/core/support.hpp"

namespace feltwire::test {

constexpr double kSamplePeriod = 1e-3;  // [s]

/// A PHANToM-like handle: 75 g, 30 um, a hand of 10 N.
inline AccountConfig handle(double damping = 0.05) {
  AccountConfig c;
  c.period = kSamplePeriod;
  c.translation.damping = damping;
  c.translation.mass = 0.075;
  c.translation.outside_force = 10.0;
  c.translation.quantum = 30e-6;
  return c;
}

inline Command push(const Vec3& force) { return {force, Vec3::Zero(), Vec3::Zero()}; }

inline BoundingStep sample(const Vec3& dx, const Command& command, double hold = kSamplePeriod) {
  return {.displacement = dx, .hold_time = hold, .command = command};
}

/// max of f y - (b/T) y^2 over 0 <= y <= reach, by search.
inline double searched_need(double f, double damping, double reach) {
  const auto taken = [&](double y) { return f * y - damping / kSamplePeriod * y * y; };
  double low = 0.0, high = reach;
  for (int i = 0; i < 200; ++i) {
    const double third = (high - low) / 3.0;
    (taken(low + third) < taken(high - third) ? low : high) =
        taken(low + third) < taken(high - third) ? low + third : high - third;
  }
  return taken(0.5 * (low + high));
}

}  // namespace feltwire::test

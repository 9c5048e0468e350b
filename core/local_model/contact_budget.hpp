#pragma once
// The share of a tick that contact may take at a client, in units of work.

#include "core/base/work_limit.hpp"

namespace feltwire {

/// The share of the servo period that is left for contact which the client computes itself.
inline constexpr double kContactShare = 0.25;
/// [s] A unit of work takes at most about this on the machines of docs/lab/benchmarks.md.
inline constexpr double kUsualUnit = 25e-9;

/// [s]
constexpr double contact_budget(double servo_period) { return kContactShare * servo_period; }

/// The units of work that fit a time [s], if one takes `unit` [s] > 0.
constexpr std::uint64_t units_within(double time, double unit = kUsualUnit) {
  return time > 0.0 ? static_cast<std::uint64_t>(time / unit) : 0;
}

/// The limit for the planes of a model of a body. Their number is small, so a fast servo may take
/// this much longer than its share.
constexpr std::uint64_t plane_work(double servo_period) {
  constexpr double kLeast = 100e-6;  // [s]
  const double budget = contact_budget(servo_period);
  return units_within(budget > kLeast ? budget : kLeast);
}

}  // namespace feltwire

#pragma once
// The errors of the bench's sensors.

#include <cmath>
#include <cstdint>

#include "core/base/splitmix.hpp"

namespace feltwire::teleop {

/// Zero mean, variance 1, at most 3.5, from four uniform numbers.
inline double noise(std::uint64_t seed, std::uint64_t n) {
  constexpr int kDraws = 4;
  constexpr double kUnit = 1.0 / 18446744073709551616.0;  // 2^-64
  double sum = 0.0;
  for (int i = 0; i < kDraws; ++i)
    sum += static_cast<double>(splitmix::draw(seed, kDraws * n + static_cast<std::uint64_t>(i))) *
           kUnit;
  return (sum - 0.5 * kDraws) * std::sqrt(12.0 / kDraws);
}

inline double rounded(double value, double quantum) {
  return quantum > 0.0 ? quantum * std::round(value / quantum) : value;
}

}  // namespace feltwire::teleop

#pragma once

#include <cmath>
#include <numbers>

namespace feltwire {

/// The share of the way to a new value that a low pass of `cutoff` [Hz] goes in `elapsed` [s].
inline double low_pass_share(double cutoff, double elapsed) noexcept {
  return 1.0 - std::exp(-2.0 * std::numbers::pi * cutoff * elapsed);
}

}  // namespace feltwire

#pragma once
// The parts of the product whose extremes a matrix judges, by name.

#include <array>
#include <string_view>

#include "sim/studies/extremes/extreme_matrix.hpp"

namespace feltwire {

struct ExtremePart {
  std::string_view name;
  /// `assumed_scale`: as in ExtremeMatrix.
  ExtremeMatrix (*run)(double assumed_scale);
};

/// Every part, in the order in which `feltwire-lab extremes --part all` runs them.
extern const std::array<ExtremePart, 5> kExtremeParts;

}  // namespace feltwire

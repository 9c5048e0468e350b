#pragma once

#include <vector>

#include "core/geometry/primitive.hpp"

namespace feltwire {

/// The numbers of a primitive [m], in the order of its lengths().
template <Primitive Solid>
std::vector<double> lengths_of(const Solid& solid) {
  std::vector<double> all;
  solid.lengths(solid, [&](const Length&, double length) { all.push_back(length); });
  return all;
}

}  // namespace feltwire

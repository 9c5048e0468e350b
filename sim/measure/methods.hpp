#pragma once
// What the lab compares: each bounding method with the options it is compared at.

#include <span>
#include <string_view>

#include "core/bounding/bounding.hpp"

namespace feltwire {

struct Method {
  std::string_view label;              // one word, as tables, files and pictures call it
  void (*configure)(BoundingConfig&);  // sets the mode and its options; period, damping and limits
                                       // are the experiment's
};

/// Every method, in the order of the tables.
std::span<const Method> methods();

/// The method of that label; throws std::invalid_argument listing the labels there are.
const Method& method(std::string_view label);

}  // namespace feltwire

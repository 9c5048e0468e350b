#pragma once
// The methods that the lab compares: each bounding method with its options.

#include <span>
#include <string_view>

#include "core/bounding/bounding.hpp"

namespace feltwire {

struct Method {
  std::string_view label;  // one word, for tables, files and pictures
  /// Sets the mode and its options; period, damping and limits are the experiment's. Null: the mode
  /// is the label, without options.
  void (*configure)(BoundingConfig&) = nullptr;

  /// Sets the mode and its options. The label must outlive the configuration.
  void apply(BoundingConfig& config) const {
    if (configure != nullptr)
      configure(config);
    else
      config.mode = label;
  }
};

/// Every method, in the order of the tables.
std::span<const Method> methods();

/// The method with that label; throws std::invalid_argument that lists the existing labels.
const Method& method(std::string_view label);

}  // namespace feltwire

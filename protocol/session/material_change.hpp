#pragma once

#include <optional>
#include <string>

namespace feltwire {

/// Another material of one object while a scene runs (core/material/material.hpp). Missing values
/// stay.
struct MaterialChange {
  std::string object = {};                      // its name
  std::optional<double> stiffness = {};         // [N/m]
  std::optional<double> damping = {};           // [N s/m]
  std::optional<double> static_friction = {};   // coefficient
  std::optional<double> dynamic_friction = {};  // coefficient
  std::optional<double> viscous_friction = {};  // [N s/m]

  friend bool operator==(const MaterialChange&, const MaterialChange&) = default;
};

}  // namespace feltwire

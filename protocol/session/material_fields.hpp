#pragma once
// The fields of a material that a live change may name.

#include <array>
#include <optional>
#include <string_view>

#include "core/material/material.hpp"
#include "protocol/session/material_change.hpp"

namespace feltwire {

struct MaterialField {
  std::string_view name;  // as scene files have it
  std::string_view unit;  // "N/m"; empty: it has none
  double Material::*value;
  std::optional<double> MaterialChange::*wanted;
};

inline constexpr std::array<MaterialField, 5> kMaterialFields = {{
    {"stiffness", "N/m", &Material::stiffness, &MaterialChange::stiffness},
    {"damping", "N s/m", &Material::damping, &MaterialChange::damping},
    {"static_friction", "", &Material::static_friction, &MaterialChange::static_friction},
    {"dynamic_friction", "", &Material::dynamic_friction, &MaterialChange::dynamic_friction},
    {"viscous_friction", "N s/m", &Material::viscous_friction, &MaterialChange::viscous_friction},
}};

}  // namespace feltwire

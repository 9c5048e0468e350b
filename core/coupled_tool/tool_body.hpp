#pragma once

#include <cstdint>
#include <memory>
#include <optional>

#include "core/coupled_tool/point_shell.hpp"

namespace feltwire {

/// All that a contact with solids needs of the tool in a hand. A server tells it once, and its
/// replies then need only say which solids are near.
struct ToolBody {
  std::uint32_t id = 0;       // two bodies that differ have two; never 0
  double contact_area = 0.0;  // [m^2] > 0: A_c of add_shell_contact()
  PointShell shell;           // its `sides` are of no use here
};

/// Null where there is none.
std::shared_ptr<const ToolBody> shared(const std::optional<ToolBody>& body);

/// The id of such a body.
std::uint32_t body_id(const PointShell& shell, double contact_area) noexcept;

}  // namespace feltwire

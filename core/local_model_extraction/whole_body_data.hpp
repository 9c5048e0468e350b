#pragma once
// What a client gets of a tool with a body and of its solids, to have them in full.

#include <optional>

#include "core/contact/contact.hpp"
#include "core/local_model/whole_body.hpp"
#include "core/scene/tool_view.hpp"

namespace feltwire {

/// The most points of a tool that travels. A client looks at all of them with every tick.
inline constexpr std::size_t kMostBodyPoints = 20'000;

/// Whether the tool touches by points, at most kMostBodyPoints.
bool can_travel(const BodyTool& tool) noexcept;
/// Whether the solid can be had in full by a client that has the tool.
bool travels(const BodyTool& tool, const Object& object) noexcept;

/// The tool as it travels. `gravity` [m/s^2]: of the world that it is in; empty: the tool's own.
/// Precondition: can_travel(tool).
BodyData body_data(const BodyTool& tool, const std::optional<Vec3>& gravity);
/// Precondition: the object travels, and `index` is its number in the scene.
SolidData solid_data(const Object& object, std::uint16_t index);

}  // namespace feltwire

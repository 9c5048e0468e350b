#pragma once
// Makes the data of a tool with a body and of its solids, which a client fetches.

#include <optional>

#include "core/local_model/prefetched_tool.hpp"
#include "core/scene/tool_view.hpp"

namespace feltwire {

/// Whether the tool touches by points, at most kMostBodyPoints.
bool can_travel(const BodyTool& tool) noexcept;

/// The tool as it travels. `gravity` [m/s^2]: of the world that it is in; empty: the tool's own.
/// Precondition: can_travel(tool).
BodyData body_data(const BodyTool& tool, const std::optional<Vec3>& gravity);
/// An object of the view without its triangles; these are of view.sampled_mesh(index).
/// Precondition: can_travel(view, index) (extract.hpp).
SolidData solid_data(const ToolView& view, std::uint16_t index);
/// With its triangles.
SolidData solid_data_with_triangles(const ToolView& view, std::uint16_t index);

}  // namespace feltwire

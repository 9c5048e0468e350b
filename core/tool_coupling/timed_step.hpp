#pragma once
// Internal to step_coupled_tool(): the step of a tool with mass.

#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire {

/// As step_coupled_tool(). Preconditions: the tool has mass, the memory is placed, and the device's
/// pose is finite.
void step_with_mass(const CoupledTool& tool, const ToolSurroundings& surroundings,
                    const Pose& device, double elapsed, BodyMemory& memory,
                    BodyStep& result) noexcept;

}  // namespace feltwire

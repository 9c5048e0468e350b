#pragma once
// Internal to the study of tools in six degrees of freedom: the tool of a task by one contact.

#include <memory>

#include "sim/studies/scene/sixdof_tasks.hpp"

namespace feltwire {

struct SixDofMethod {
  bool polygons = false, mass = false;
  bool midpoint = false;  // of a tool with mass; else it is implicit
};

inline constexpr double kSixDofPeriod = 1e-3;       // [s]
inline constexpr double kSixDofStiffness = 1000.0;  // [N/m] of material and coupling

/// A tool and the solid that it touches.
struct SixDofTool {
  BodyTool tool;
  Object solid;
  std::shared_ptr<const PolygonBody> polygons = nullptr;  // null: points

  BodyStep step(const Pose& device, double elapsed, BodyMemory& memory) const {
    return step_body(tool, std::span(&solid, 1), device, elapsed, memory);
  }
};

/// `points` of a tool of points, and `grid_steps` of the grid that it touches.
SixDofTool sixdof_tool(const SixDofTask& task, SixDofMethod method, std::size_t points,
                       double grid_steps);

/// Returns the tool with another stiffness [N/m] of material and coupling, and without a damper
/// beside the coupling.
SixDofTool stiffer(const SixDofTool& tool, double stiffness);

/// [bytes] The memory that the contact reads: shell and grid, or parts.
std::size_t contact_bytes(const SixDofTool& tool);

}  // namespace feltwire

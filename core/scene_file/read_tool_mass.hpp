#pragma once
// Internal to read_fields.cpp: reads the mass of a tool's body.

#include <optional>
#include <string>

#include "core/base/json_document.hpp"
#include "core/geometry/shapes.hpp"
#include "core/mesh/triangle_mesh.hpp"
#include "core/tool_coupling/tool_inertia.hpp"

namespace feltwire {

namespace scene_file {
struct Scene;
struct ToolBody;
}  // namespace scene_file

/// The mass, centre and inertia of the body at `path`, in the tool's frame, with the scene's
/// gravity. `shape`, or else `surface`, both in the body's frame: its solid. `place`: of that frame
/// in the tool's. Mass 0: the file gives the body none. Throws FileError.
ToolInertia read_tool_mass(const JsonDocument& document, const std::string& path,
                           const scene_file::ToolBody& body, const scene_file::Scene& scene,
                           const std::optional<Shape>& shape, const TriangleSoup& surface,
                           const Pose& place);

}  // namespace feltwire

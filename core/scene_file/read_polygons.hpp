#pragma once
// Internal to load_scene.cpp: reads a tool of polygons.

#include <filesystem>
#include <memory>

#include "core/scene/scene.hpp"
#include "core/scene_file/scene_generated.h"
#include "core/tool/polygon_body.hpp"

namespace feltwire {

/// The convex parts of the body at `path`, whose surface in its own frame is `surface`, put at
/// `place` in the tool's frame; and those of all objects of the scene. Null for a body of points.
/// Throws FileError that names the field and the remedy.
std::shared_ptr<const PolygonBody> read_polygons(const JsonDocument& document,
                                                 const std::string& path,
                                                 const scene_file::ToolBody& body,
                                                 const TriangleSoup& surface, const Pose& place,
                                                 const std::filesystem::path& folder,
                                                 const scene_file::Scene& file, const Scene& scene);

}  // namespace feltwire

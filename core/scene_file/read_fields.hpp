#pragma once
// Internal to load_scene.cpp: grids and tools from a scene file.

#include <filesystem>

#include "core/scene/scene.hpp"
#include "core/scene_file/scene_generated.h"

namespace feltwire {

/// The grid of an object; `path` is the field's, `folder` what file names are relative to. Throws
/// FileError.
Grid read_grid(const JsonDocument& document, const std::string& path, const scene_file::Grid& grid,
               const std::filesystem::path& folder);

/// Puts what the file says of tools into the scene's hands. Throws FileError.
void read_tools(const JsonDocument& document, const scene_file::Scene& file,
                const std::filesystem::path& folder, Scene& scene);

}  // namespace feltwire

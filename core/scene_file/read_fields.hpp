#pragma once
// Internal to load_scene.cpp: reads the grids and the tools of a scene file.

#include <filesystem>

#include "core/scene/scene.hpp"
#include "core/scene_file/scene_generated.h"

namespace feltwire {

/// The grid of the field at `path`. File names are relative to `folder`. Throws FileError.
/// `warnings`: about its file.
Grid read_grid(const JsonDocument& document, const std::string& path, const scene_file::Grid& grid,
               const std::filesystem::path& folder, std::vector<std::string>& warnings);

/// Gives the scene the tool or the tools of the file, if it has any, and the warnings about their
/// files. Throws FileError.
void read_tools(const JsonDocument& document, const scene_file::Scene& file,
                const std::filesystem::path& folder, Scene& scene);

}  // namespace feltwire

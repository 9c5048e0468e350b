#pragma once
// A scene from its file.

#include <filesystem>
#include <string>
#include <string_view>

#include "core/scene/scene.hpp"

namespace feltwire {

/// Reads a scene file (JSON against core/scene_file/scene.fbs). Throws FileError.
Scene load_scene(const std::filesystem::path& file);

/// The same from text; `file` is only what errors call it.
Scene parse_scene(std::string_view json, const std::string& file);

}  // namespace feltwire

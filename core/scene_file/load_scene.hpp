#pragma once
// Loads a scene from its file.

#include <filesystem>
#include <string>
#include <string_view>

#include "core/scene/scene.hpp"

namespace feltwire {

/// Reads a scene file (JSON, checked against core/scene_file/scene.fbs) and the files that it
/// names. Throws FileError that names the file, the line, the field and the remedy.
Scene load_scene(const std::filesystem::path& file);

/// Like load_scene(), from text. Errors call it `file`; its file names are relative to that folder.
Scene parse_scene(std::string_view json, const std::string& file);

/// Like load_scene(), and keeps the files in the scene, so that load_kept_scene() loads it again,
/// with those that MuJoCo reads for an mjcf.
Scene load_scene_and_keep(const std::filesystem::path& file);
/// Reads from the disk only the files that it puts there itself for MuJoCo, in a folder for
/// temporary files. Throws FileError.
Scene load_kept_scene(const CapturedFiles& files);

}  // namespace feltwire

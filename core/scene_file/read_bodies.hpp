#pragma once
// Internal to load_scene.cpp: reads the bodies of a scene file, or its MJCF file.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/base/json_document.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire {

namespace scene_file {
struct Scene;
}

/// Finds the scene's material of a name. Throws FileError that names `path` if there is none.
using FindMaterial = std::function<const Material&(const std::string& path, const std::string&)>;

/// The moving part of a scene, and the origin of its convex parts.
struct ReadMechanism {
  std::shared_ptr<const Mechanism> mechanism;  // null: nothing moves
  std::vector<std::string> notes, warnings;    // of the parts
};

/// Compiles the bodies of the file. `objects` holds the objects in the order of the file; those of
/// bodies are placed in the world and moved behind the others. `folder`: of the file. Throws
/// FileError.
ReadMechanism read_bodies(const JsonDocument& document, const scene_file::Scene& scene,
                          const std::filesystem::path& folder, std::vector<Object>& objects);

/// Loads the MJCF file that the scene names, relative to `folder`, and adds its objects to
/// `objects`. The arms of `seats` begin at home. Throws FileError.
std::shared_ptr<const Mechanism> read_mjcf(const JsonDocument& document,
                                           const scene_file::Scene& scene,
                                           const std::filesystem::path& folder,
                                           const std::vector<RemoteSeat>& seats,
                                           const FindMaterial& find_material,
                                           std::vector<Object>& objects);

}  // namespace feltwire

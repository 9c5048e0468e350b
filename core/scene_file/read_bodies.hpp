#pragma once
// Internal to load_scene.cpp: what moves, out of a scene file.

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

/// The scene's material of that name; fails naming `path` where there is none.
using FindMaterial = std::function<const Material&(const std::string& path, const std::string&)>;

/// Compiles the bodies of the file, and places their objects, which stand in `objects` as the file
/// has them and are put behind the others. Null: nothing moves.
std::shared_ptr<const Mechanism> read_bodies(const JsonDocument& document,
                                             const scene_file::Scene& scene,
                                             std::vector<Object>& objects);

/// Loads the MJCF file that the scene names, relative to `folder`.
std::shared_ptr<const Mechanism> read_mjcf(const JsonDocument& document,
                                           const scene_file::Scene& scene,
                                           const std::filesystem::path& folder,
                                           const FindMaterial& find_material,
                                           std::vector<Object>& objects);

}  // namespace feltwire

#pragma once
// Makes the moving part of a scene from an MJCF file.

#include <filesystem>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/scene/mechanism.hpp"

namespace feltwire {

/// The materials for the geoms of an MJCF file.
struct MjcfMaterials {
  struct Named {
    std::string name;  // of a geom, or of a material of the file; a geom's own name wins
    Material material;
    std::string material_name = {};  // in the scene file
  };
  Material other;               // of all other geoms
  std::string other_name = {};  // in the scene file
  std::vector<Named> named;
};

/// Moves joints to where they start, in `coordinates` (qpos of that model). May throw FileError.
using SetStart = std::function<void(const mjModel_& model, double* coordinates)>;

/// Reads an MJCF file. Its colliding geoms become objects (added to `objects`, which must be
/// empty). Geoms that collide with nothing are decoration and are not felt. `set_start` may be
/// empty. Throws FileError that names the file and the geom, or quotes MuJoCo's message.
std::shared_ptr<const Mechanism> load_mjcf(const std::filesystem::path& file,
                                           const MjcfMaterials& materials, double tick,
                                           std::vector<Object>& objects,
                                           const SetStart& set_start = {});

}  // namespace feltwire

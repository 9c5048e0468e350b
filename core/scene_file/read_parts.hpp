#pragma once
// Internal to the readers of a scene file: the convex parts that bodies collide with.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/json_document.hpp"
#include "core/convex/decomposition.hpp"
#include "core/scene/mechanism.hpp"

namespace feltwire {

namespace scene_file {
struct Mesh;
struct Scene;
}  // namespace scene_file

/// The options of the mesh at `path`; whether they fit the surface is checked, too. Throws
/// FileError that names the field.
DecompositionOptions read_parts_options(const JsonDocument& document, const std::string& path,
                                        const scene_file::Mesh& mesh, const MeshSurface& surface);

struct CollisionParts {
  std::vector<std::shared_ptr<const ConvexSolids>> of_object;  // null: its own shape
  std::vector<std::string> notes;                              // origin of the parts, one line each
  std::vector<std::string> warnings;                           // a line each, with the remedy
};

/// The convex parts of the meshes that bodies collide with: closed, hollow ones, felt from outside,
/// that are static or whose body collides, in a scene with a body that collides. Each is computed
/// or read once (core/scene_file/parts_cache.hpp). `objects`, `body_of` and `bodies` as for
/// compile(); the objects are in the order of the file. Throws FileError, Cancelled and
/// std::bad_alloc.
CollisionParts read_collision_parts(const JsonDocument& document, const scene_file::Scene& scene,
                                    const std::filesystem::path& folder,
                                    const std::vector<Object>& objects,
                                    const std::vector<int>& body_of,
                                    const std::vector<Body>& bodies);

}  // namespace feltwire

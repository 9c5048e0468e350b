#pragma once
// Internal to the readers of a scene file: the convex parts that bodies collide with.

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "core/base/json_document.hpp"
#include "core/convex/decomposition.hpp"
#include "core/dynamics/mujoco_compile.hpp"

namespace feltwire {

namespace scene_file {
struct ConvexParts;
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

/// A mesh that a tool of polygons needs in parts.
struct ToolMesh {
  std::string path;  // of its field
  std::string name;  // of the file
  std::string use;   // scale and options as part of a kept file's name
};

/// Its convex parts, in the coordinates of the surface [m], without corners that stand out by less
/// than a quarter of the tolerance. Throws FileError at `path` if there are none.
std::vector<std::vector<Vec3>> read_tool_parts(const JsonDocument& document,
                                               const std::filesystem::path& folder,
                                               const ToolMesh& mesh, const MeshSurface& surface,
                                               const DecompositionOptions& options);

/// Reads these options from the field at `own`; null: the default.
DecompositionOptions read_parts_options(const JsonDocument& document, const std::string& own,
                                        const scene_file::ConvexParts* given,
                                        const MeshSurface& surface);

/// The mesh of a closed object that is not convex and felt from outside; null: all others.
const MeshSurface* hollow_mesh(const Object& object);

/// Scale and options of an object's mesh as part of a kept file's name.
std::string use_of(const scene_file::Mesh& mesh);

}  // namespace feltwire

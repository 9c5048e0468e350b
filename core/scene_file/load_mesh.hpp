#pragma once
// The meshes of a scene file.

#include <filesystem>
#include <map>
#include <optional>
#include <string>
#include <utility>
#include <vector>

#include "core/base/json_document.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

namespace scene_file {
struct Mesh;
}

/// A warning about a file with a size [m] that suggests another unit, with the scale that would
/// give a usual one. `scale`: what was used [m per unit of the file]. Empty: the size is usual.
std::optional<std::string> odd_size(const std::string& name, double size, double scale);

/// Loads meshes. A file that several objects name is read once.
class MeshLoader {
 public:
  /// Paths of files are relative to `folder`. The document must outlive this.
  MeshLoader(const JsonDocument& document, std::filesystem::path folder)
      : document_(document), folder_(std::move(folder)) {}

  /// Meshes with faces that no neighbour decides are read as solids from now on: a tool with a body
  /// touches them.
  void take_all_for_solids() { solids_ = true; }

  /// The mesh of the field at `path`. `moves`: it belongs to a body, so it is a solid. Throws
  /// FileError that names this field, or the mesh file and its line.
  Mesh load(const std::string& path, const scene_file::Mesh& mesh, bool moves = false);

  /// Warnings about the files that were read: values that are valid but look like mistakes.
  std::vector<std::string>& warnings() { return warnings_; }

 private:
  const JsonDocument& document_;
  std::filesystem::path folder_;
  std::map<std::string, Mesh> known_;
  std::vector<std::string> warnings_;
  bool solids_ = false;
};

}  // namespace feltwire

#pragma once
// The meshes of a scene file.

#include <filesystem>
#include <map>
#include <string>
#include <vector>

#include "core/base/json_document.hpp"
#include "core/geometry/shapes.hpp"

namespace feltwire {

namespace scene_file {
struct Mesh;
}

/// Loads meshes. A file that several objects name is read once.
class MeshLoader {
 public:
  /// Paths of files are relative to `folder`. The document must outlive this.
  MeshLoader(const JsonDocument& document, std::filesystem::path folder)
      : document_(document), folder_(std::move(folder)) {}

  /// The mesh of the field at `path`. Throws FileError that names this field, or the mesh file and
  /// its line.
  Mesh load(const std::string& path, const scene_file::Mesh& mesh);

  /// Warnings about the files that were read: values that are valid but look like mistakes.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  const JsonDocument& document_;
  std::filesystem::path folder_;
  std::map<std::string, Mesh> known_;
  std::vector<std::string> warnings_;
};

}  // namespace feltwire

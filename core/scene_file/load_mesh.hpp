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

/// Reads each file once, however many objects are made of it.
class MeshLoader {
 public:
  /// `folder`: what the files' paths are relative to. The document must outlive this.
  MeshLoader(const JsonDocument& document, std::filesystem::path folder)
      : document_(document), folder_(std::move(folder)) {}

  /// Throws FileError naming the scene's field, and for a mesh file's own faults its line.
  Mesh load(const std::string& path, const scene_file::Mesh& mesh);

  /// Warnings about the files: strange, but no error.
  const std::vector<std::string>& warnings() const { return warnings_; }

 private:
  const JsonDocument& document_;
  std::filesystem::path folder_;
  std::map<std::string, Mesh> known_;
  std::vector<std::string> warnings_;
};

}  // namespace feltwire

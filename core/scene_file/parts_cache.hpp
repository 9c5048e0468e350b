#pragma once
// Convex parts of the meshes of scenes, kept on the disk, so that the next load does not compute
// them again.

#include <filesystem>
#include <string>
#include <vector>

#include "core/convex/stored_parts.hpp"

namespace feltwire {

struct FoundParts {
  ConvexParts parts;
  bool computed = false;
  double seconds = 0.0;              // that computing took, by the wall clock
  std::string place;                 // the file that has them; empty: none
  std::vector<std::string> remarks;  // on files that were not used or not written
};

/// A mesh file as a scene names it.
struct NamedMesh {
  std::filesystem::path folder;  // of the scene's file
  std::string name;              // relative to it
  std::string use;               // scale and options as part of a file's name: "0.01.auto.64"
};

/// Where the parts of a mesh are kept: beside it as NAME.USE.convex, where the mesh, its links
/// followed, lies in the scene's folder or below it; and in the user's cache folder.
std::vector<std::filesystem::path> places_of_parts(const NamedMesh& mesh, const PartsKey& key);

/// The parts from the first of these places that has them, else from convex_parts(), which throws
/// as it says; they are then written to the first place that takes them. A file counts if it is a
/// regular one that this user, the mesh file's owner or root owns and if stored_parts() takes its
/// bytes. Where the calling thread keeps what it reads (core/base/kept_files.hpp), the parts are
/// among it; where it reads what is given, they come from there or are computed, and nothing is
/// written.
FoundParts find_parts(const NamedMesh& mesh, const MeshSurface& surface,
                      const DecompositionOptions& options);

}  // namespace feltwire

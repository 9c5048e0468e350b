#pragma once
// Convex parts of the meshes of scenes, kept on the disk, so that the next load does not compute
// them again.

#include <filesystem>
#include <string>
#include <vector>

#include "core/convex/convex_parts_file.hpp"

namespace feltwire {

struct FoundParts {
  ConvexParts parts;
  bool computed = false;
  double seconds = 0.0;              // computing time, by the wall clock
  std::string place;                 // the file with them; empty: none
  std::vector<std::string> remarks;  // on files that were not used or not written
};

/// A mesh file as a scene names it.
struct NamedMesh {
  std::filesystem::path folder;  // of the scene's file
  std::string name;              // relative to it
  std::string use;               // scale and options as part of a file's name: "0.01.auto.64"
};

/// The places for the parts of a mesh: beside it as NAME.USE.convex, if the mesh, its links
/// followed, lies in the scene's folder or below it; and in the user's cache folder.
std::vector<std::filesystem::path> places_of_parts(const NamedMesh& mesh, const PartsKey& key);

/// Returns the parts from the first of these places that has them, else from convex_parts(), with
/// its exceptions; they are then written to the first place that is writable. A file counts if it
/// is a regular one that this user, the mesh file's owner or root owns and if read_convex_parts()
/// accepts its bytes. If the calling thread keeps the files that it reads
/// (core/base/captured_files.hpp), the parts are among them. If it reads only given files, the
/// parts come from there or are computed, and nothing is written.
FoundParts find_parts(const NamedMesh& mesh, const MeshSurface& surface,
                      const DecompositionOptions& options);

}  // namespace feltwire

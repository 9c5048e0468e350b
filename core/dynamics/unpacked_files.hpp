#pragma once
// Files that were kept in memory, on the disk again, for a library that reads no memory.

#include <filesystem>
#include <string>

#include "core/base/kept_files.hpp"

namespace feltwire {

/// The files in a folder of their own, which goes with this object. A name may lead out of the
/// folder of the scene (../meshes/a.stl): it stays within root() all the same.
class UnpackedFiles {
 public:
  /// Throws FileError, also for a name that begins at the root of the file system.
  explicit UnpackedFiles(const FileBytes& files);
  ~UnpackedFiles();
  UnpackedFiles(const UnpackedFiles&) = delete;
  UnpackedFiles& operator=(const UnpackedFiles&) = delete;

  /// An absolute path without links. Nothing else is in it.
  const std::filesystem::path& root() const { return root_; }
  /// Where the file of this name is.
  std::filesystem::path place(const std::string& name) const { return scene_ / name; }

 private:
  void write(const FileBytes& files);

  std::filesystem::path root_, scene_;
};

}  // namespace feltwire

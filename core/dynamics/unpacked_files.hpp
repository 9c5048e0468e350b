#pragma once
// Writes kept files to the disk again, for a library that cannot read memory.

#include <filesystem>
#include <string>

#include "core/base/captured_files.hpp"

namespace feltwire {

/// The files in a folder of their own, which is removed with this object. A name may lead out of
/// the folder of the scene (../meshes/a.stl); the file stays within root().
class UnpackedFiles {
 public:
  /// Throws FileError, also for a name that begins at the root of the file system.
  explicit UnpackedFiles(const FileBytes& files);
  ~UnpackedFiles();
  UnpackedFiles(const UnpackedFiles&) = delete;
  UnpackedFiles& operator=(const UnpackedFiles&) = delete;

  /// An absolute path without links. It contains nothing else.
  const std::filesystem::path& root() const { return root_; }
  /// The path of the file with this name.
  std::filesystem::path place(const std::string& name) const { return scene_ / name; }

 private:
  void write(const FileBytes& files);

  std::filesystem::path root_, scene_;
};

}  // namespace feltwire

#pragma once

#include <filesystem>

namespace feltwire {

/// Held, no other process holds it: of a file of its own, made where there is none.
class FileLock {
 public:
  /// Waits for it. Throws FileError.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace feltwire

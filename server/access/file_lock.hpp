#pragma once

#include <filesystem>

namespace feltwire {

/// A lock that only one process holds at a time, on a file of its own, which it creates if it is
/// missing.
class FileLock {
 public:
  /// Waits for the lock. Throws FileError.
  explicit FileLock(const std::filesystem::path& file);
  ~FileLock();
  FileLock(const FileLock&) = delete;
  FileLock& operator=(const FileLock&) = delete;

 private:
  int descriptor_;
};

}  // namespace feltwire

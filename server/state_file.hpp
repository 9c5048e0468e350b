#pragma once
// Files of the server's state: written whole or not at all, by one process at a time.

#include <sys/types.h>

#include <filesystem>
#include <string_view>

namespace feltwire {

inline constexpr mode_t kPrivate = 0600, kPublic = 0644;

/// Puts a file in place at once (a new one, renamed over the old): who reads it gets the old text
/// or the new one. Throws FileError.
void write_state(const std::filesystem::path& file, std::string_view text, mode_t mode);

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

#pragma once
// Files of the server's state: written whole or not at all, by one process at a time.

#include <sys/types.h>

#include <filesystem>
#include <string>
#include <string_view>

namespace feltwire {

inline constexpr mode_t kPrivate = 0600, kPublic = 0644;

/// A file that is written, and not in place yet: whatever can fail for want of room, or of a
/// folder, has failed before it is.
class PendingFile {
 public:
  /// Writes beside `file`. Throws FileError.
  PendingFile(std::filesystem::path file, std::string_view text, mode_t mode);
  /// Removes what was written, unless it is in place.
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// Puts it in place at once: who reads the file gets the old text or the new one. Throws
  /// FileError.
  void put_in_place();

 private:
  std::filesystem::path file_;
  std::string written_;  // empty: in place
};

/// Writes a file and puts it in place. Throws FileError.
void write_state(const std::filesystem::path& file, std::string_view text, mode_t mode);

/// Removes what a writer of this file left over that was ended in the middle. Nobody may be writing
/// it.
void remove_leftovers(const std::filesystem::path& file);

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

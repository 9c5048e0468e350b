#pragma once
// A file that is replaced in one step: a reader gets the old text or the new one, never a part.

#include <sys/types.h>

#include <filesystem>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/file_error.hpp"

namespace feltwire {

inline constexpr mode_t kPrivate = 0600, kPublic = 0644;
/// For the mode of a file: kPublic reduced by the umask.
inline constexpr std::optional<mode_t> kByUmask = std::nullopt;

/// A new text of a file, complete on the disk beside it. If the disk is full or the folder cannot
/// be written, the constructor throws, and the old text stays.
class PendingFile {
 public:
  /// Throws FileError, also for a folder, a pipe or a device, because a rename would replace it.
  PendingFile(std::filesystem::path file, std::string_view text, std::optional<mode_t> mode);
  /// Removes the written text, unless it is in place.
  ~PendingFile();
  PendingFile(const PendingFile&) = delete;
  PendingFile& operator=(const PendingFile&) = delete;

  /// Renames it to `file`, and flushes the new name to the disk. Throws FileError.
  void put_in_place();

 private:
  std::filesystem::path file_;
  std::string written_;  // empty: in place
};

/// Writes a file and puts it in place. Throws FileError.
void replace_file(const std::filesystem::path& file, std::string_view text,
                  std::optional<mode_t> mode);

/// Removes the remains of processes that were ended while they wrote this file. No other process
/// may be writing it.
void remove_leftovers(const std::filesystem::path& file);

/// Whether it exists and is neither a regular file nor a folder, for example a pipe or a terminal.
bool is_special(const std::filesystem::path& file);

/// Writes all bytes to an open descriptor. False if the system refuses, with the reason in errno.
bool write_all(int descriptor, std::string_view text);

/// Throws FileError "cannot write FILE: REASON; what to do".
[[noreturn]] void cannot_write(const std::filesystem::path& file, const char* reason);

}  // namespace feltwire

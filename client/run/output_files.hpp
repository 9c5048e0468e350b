#pragma once
// The files that a run writes, checked before anything is written.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// A file that the command line names, and the option that does.
struct NamedFile {
  std::string option;
  std::filesystem::path path;
};

/// Throws std::invalid_argument naming both options and the file when two of `written` are the same
/// file, or one of `written` is one of `read`: by the same path, by another path, a hard link or a
/// symbolic link, whether or not the file is there already. A pipe or a device (/dev/null) may be
/// named twice.
void require_different(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read);

/// The file that is meant: symbolic links followed to their end, also one whose file is not there
/// yet.
std::filesystem::path followed(const std::filesystem::path& file);

/// Throws FileError naming the file and the reason when write_whole() could not write it now.
/// Leaves nothing.
void check_writable(const std::filesystem::path& file);

/// Replaces the file in one step, or the one that a link means. Writes directly to a file that is
/// not regular (a pipe, /dev/stdout). Throws FileError.
void write_whole(const std::filesystem::path& file, std::string_view text);

}  // namespace feltwire

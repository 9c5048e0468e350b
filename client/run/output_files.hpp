#pragma once
// The files that a run writes, checked before anything is written.

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// A file of the command line, and its option.
struct NamedFile {
  std::string option;
  std::filesystem::path path;
};

/// Throws std::invalid_argument that names both options and the file if two of `written` are the
/// same file, or one of `written` is one of `read`: by the same path, by another path, a hard link
/// or a symbolic link, whether or not the file exists. A pipe or a device (/dev/null) may be named
/// twice.
void require_different(const std::vector<NamedFile>& written, const std::vector<NamedFile>& read);

/// Returns the file after following symbolic links, also if it does not exist yet.
std::filesystem::path followed(const std::filesystem::path& file);

/// Throws FileError that names the file and the reason if write_whole() could not write it now. It
/// leaves no file behind.
void check_writable(const std::filesystem::path& file);

/// Replaces the file in one step, or the target of a link. Its owner alone may read it (mode 0600),
/// because it tells of a person. Writes directly to a file that is not
/// regular (a pipe, /dev/stdout). Throws FileError.
void write_whole(const std::filesystem::path& file, std::string_view text);

}  // namespace feltwire

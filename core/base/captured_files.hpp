#pragma once
// The files that an operation reads, kept so that they can be read again on another machine.

#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace feltwire {

/// File contents by the normalized name with which they were read.
using FileBytes = std::map<std::string, std::string>;

/// The mode of read_regular_file() in one thread: the source of the bytes, and whether it keeps
/// them.
struct FileReading {
  FileBytes* keep = nullptr;         // receives the read files; null: they are not kept
  const FileBytes* given = nullptr;  // the files that may be read; null: the disk is read
};
inline thread_local FileReading file_reading_of_this_thread;

/// While this object lives, the calling thread keeps the files that it reads, or reads only the
/// given files and nothing from the disk.
class FileReadingScope {
 public:
  explicit FileReadingScope(FileReading reading) noexcept
      : before_(std::exchange(file_reading_of_this_thread, reading)) {}
  ~FileReadingScope() { file_reading_of_this_thread = before_; }
  FileReadingScope(const FileReadingScope&) = delete;
  FileReadingScope& operator=(const FileReadingScope&) = delete;

 private:
  FileReading before_;
};

inline std::string captured_name(const std::filesystem::path& file) {
  return file.lexically_normal().generic_string();
}

/// Returns the path of a file that another file names relative to its own folder.
struct CapturedFiles {
  std::string main;
  FileBytes files;
};

}  // namespace feltwire

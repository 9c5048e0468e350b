#pragma once
// The files that a piece of work reads, kept to be read again elsewhere.

#include <filesystem>
#include <map>
#include <string>
#include <utility>

namespace feltwire {

/// By the name that they were read by, normalized; the bytes.
using FileBytes = std::map<std::string, std::string>;

/// How read_regular_file() works in one thread: where it reads from, and whether it keeps the
/// bytes.
struct FileReading {
  FileBytes* keep = nullptr;         // gets what is read; null: it is not kept
  const FileBytes* given = nullptr;  // has what may be read; null: the disk has
};
inline thread_local FileReading file_reading_of_this_thread;

/// While this object lives, the calling thread keeps what it reads, or reads what is given and
/// nothing from the disk.
class ReadingFiles {
 public:
  explicit ReadingFiles(FileReading reading) noexcept
      : before_(std::exchange(file_reading_of_this_thread, reading)) {}
  ~ReadingFiles() { file_reading_of_this_thread = before_; }
  ReadingFiles(const ReadingFiles&) = delete;
  ReadingFiles& operator=(const ReadingFiles&) = delete;

 private:
  FileReading before_;
};

inline std::string kept_name(const std::filesystem::path& file) {
  return file.lexically_normal().generic_string();
}

/// A file and those that it names, which are named from its folder.
struct KeptFiles {
  std::string main;
  FileBytes files;
};

}  // namespace feltwire

#pragma once
// A file that a connection sends, a piece at a time.

#include <cstdint>
#include <filesystem>
#include <vector>

namespace feltwire::web {

/// Reads a regular file as long as it was when it was opened. So it stores one piece at a time,
/// however long the file is.
class SentFile {
 public:
  static constexpr std::size_t kPiece = std::size_t{32} * 1024;  // [bytes]

  /// Throws std::system_error if there is no regular file at the path itself, which is no link.
  explicit SentFile(const std::filesystem::path& path);
  ~SentFile();
  SentFile(const SentFile&) = delete;
  SentFile& operator=(const SentFile&) = delete;

  /// [bytes] of the whole file.
  std::uint64_t size() const { return size_; }
  /// The next bytes; empty at the end. Throws std::system_error if they cannot be read, or if the
  /// file has become shorter.
  std::vector<std::uint8_t> next();

 private:
  int descriptor_ = -1;
  std::uint64_t size_ = 0, read_ = 0;
};

}  // namespace feltwire::web

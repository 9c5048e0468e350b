#pragma once
// A file that only grows, each time by a whole piece. It stays readable even if the run is killed.
// Its contents are a person's: its owner alone may read it.

#include <cstddef>
#include <cstdint>
#include <filesystem>
#include <string>
#include <string_view>

namespace feltwire {

class AppendedFile {
 public:
  /// Creates or replaces the file, with mode 0600: one that is open to other users is closed to
  /// them. Errors use `what` (the kind of file) and `option` (the option
  /// that named it). Throws std::runtime_error that names the file and the reason, as the other
  /// functions do.
  AppendedFile(std::filesystem::path file, std::string what, const std::string& option);
  ~AppendedFile();
  AppendedFile(const AppendedFile&) = delete;
  AppendedFile& operator=(const AppendedFile&) = delete;

  /// Returns how many of the bytes that fitted on a full disk are worth keeping.
  using Whole = std::size_t (*)(std::string_view written);

  /// Writes the piece, in as few system calls as possible. If the disk is full, none of it stays,
  /// or the part that `whole` returns.
  void append(
      std::string_view piece, Whole whole = [](std::string_view) { return std::size_t{0}; });
  /// Flushes the file to the disk and closes it.
  void finish();

  /// [bytes] that were appended.
  std::uint64_t size() const { return static_cast<std::uint64_t>(size_); }

 private:
  [[noreturn]] void fail(int error);

  std::filesystem::path file_;
  std::string what_;
  int descriptor_ = -1;
  std::int64_t size_ = 0;
};

}  // namespace feltwire

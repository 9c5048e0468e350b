#pragma once
// A text file that is written in whole lines. It stays readable even if the run is killed.

#include <cstdint>
#include <filesystem>
#include <string>

namespace feltwire {

/// Nine digits: a nanometre in a metre, a nanonewton in a newton.
void append(std::string& line, double value);

class LineFile {
 public:
  /// Creates or replaces the file and writes the first line. Errors use `what` (the kind of file)
  /// and `option` (the option that named it). Throws std::runtime_error that names the file and the
  /// reason; so does put().
  LineFile(std::filesystem::path file, std::string what, const std::string& option,
           std::string header);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  /// Adds whole lines, which the next put() writes.
  std::string& lines() { return lines_; }
  /// Writes the lines, in as few system calls as possible. If the disk is full, the file ends with
  /// the last whole line.
  void put();
  /// Flushes the file to the disk and closes it.
  void finish();

 private:
  [[noreturn]] void fail(int error);

  std::filesystem::path file_;
  std::string what_;
  int descriptor_ = -1;
  std::string lines_;
  std::int64_t whole_ = 0;  // [bytes] of the file up to the end of its last whole line
};

}  // namespace feltwire

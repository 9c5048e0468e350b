#pragma once
// A text file that is written in whole lines. It stays readable even if the run is killed.

#include <filesystem>
#include <string>

#include "core/base/appended_file.hpp"

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

  /// Adds whole lines, which the next put() writes.
  std::string& lines() { return lines_; }
  /// Writes the lines, in as few system calls as possible. If the disk is full, the file ends with
  /// the last whole line.
  void put();
  /// Flushes the file to the disk and closes it.
  void finish() { file_.finish(); }

 private:
  AppendedFile file_;
  std::string lines_;
};

}  // namespace feltwire

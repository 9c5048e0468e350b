#pragma once
// A text file that is written in whole lines, so that it stays readable however the run ends.

#include <cstdint>
#include <filesystem>
#include <string>

namespace feltwire {

/// Nine digits: a nanometre in a metre, a nanonewton in a newton.
void append(std::string& line, double value);

class LineFile {
 public:
  /// Creates or replaces the file and writes the first line. `what` it is and which `option` named
  /// it are for errors. Throws std::runtime_error naming the file and the reason, likewise put().
  LineFile(std::filesystem::path file, std::string what, const std::string& option,
           std::string header);
  ~LineFile();
  LineFile(const LineFile&) = delete;
  LineFile& operator=(const LineFile&) = delete;

  /// Lines, whole, to be written with the next put().
  std::string& lines() { return lines_; }
  /// Writes them, in as few calls as the system allows. Where it takes no more (a full disk), the
  /// file ends with the last whole line.
  void put();
  /// Has what was written be on the disk; nothing can be written afterwards.
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

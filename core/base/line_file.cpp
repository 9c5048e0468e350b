#include "core/base/line_file.hpp"

#include <array>
#include <charconv>
#include <cstddef>
#include <string_view>
#include <utility>

namespace feltwire {
namespace {

/// Returns the length [bytes] of the complete lines in `written`.
std::size_t whole_lines(std::string_view written) {
  const std::size_t last = written.rfind('\n');
  return last == std::string_view::npos ? 0 : last + 1;
}

}  // namespace

void append(std::string& line, double value) {
  constexpr int kDigits = 9;
  std::array<char, 32> text{};
  const auto end = std::to_chars(text.data(), text.data() + text.size(), value,
                                 std::chars_format::general, kDigits)
                       .ptr;
  line.append(text.data(), end);
}

LineFile::LineFile(std::filesystem::path file, std::string what, const std::string& option,
                   std::string header)
    : file_(std::move(file), std::move(what), option), lines_(std::move(header)) {
  put();
}

void LineFile::put() {
  try {
    file_.append(lines_, whole_lines);
  } catch (...) {
    lines_.clear();  // The file already has a part of these lines, so do not write them again.
    throw;
  }
  lines_.clear();
}

}  // namespace feltwire

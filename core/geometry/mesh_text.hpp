#pragma once
// Internal to the mesh files: words of a text line by line, with errors that name the line.

#include <charconv>
#include <cmath>
#include <string>
#include <string_view>

#include "core/file_error.hpp"
#include "core/types.hpp"

namespace feltwire::mesh_text {

/// A text cut into lines, these into words at white space.
class Words {
 public:
  Words(std::string_view text, const std::string& name) : text_(text), name_(name) {}

  [[noreturn]] void fail(const std::string& message) const {
    throw FileError(name_ + ":" + std::to_string(line_) + ": " + message);
  }

  /// The next line that is not empty; false at the end.
  bool next_line() {
    while (at_ < text_.size()) {
      std::size_t end = text_.find('\n', at_);
      if (end == std::string_view::npos) end = text_.size();
      rest_ = text_.substr(at_, end - at_);
      at_ = end + 1;
      ++line_;
      skip_space();
      if (!rest_.empty()) return true;
    }
    rest_ = {};
    return false;
  }

  /// The next word of the line, empty at its end.
  std::string_view word() {
    std::size_t end = 0;
    while (end < rest_.size() && !is_space(rest_[end])) ++end;
    const std::string_view found = rest_.substr(0, end);
    rest_.remove_prefix(end);
    skip_space();
    return found;
  }
  bool line_ended() const { return rest_.empty(); }
  std::string_view rest() const { return rest_; }

  double number(const char* what) {
    std::string_view w = word();
    const std::string_view written = w;
    if (!w.empty() && w.front() == '+') w.remove_prefix(1);
    double value = 0.0;
    const auto read = std::from_chars(w.data(), w.data() + w.size(), value);
    if (w.empty() || read.ec != std::errc{} || read.ptr != w.data() + w.size() ||
        !std::isfinite(value))
      fail(std::string(what) + ": must be a number, is " + shown(written) +
           "; export the surface anew");
    return value;
  }
  Vec3 vector(const char* what) {
    const double x = number(what), y = number(what), z = number(what);
    return {x, y, z};
  }
  long long whole(std::string_view w, const char* what) const {
    long long value = 0;
    const auto read = std::from_chars(w.data(), w.data() + w.size(), value);
    if (w.empty() || read.ec != std::errc{} || read.ptr != w.data() + w.size())
      fail(std::string(what) + ": must be a whole number, is " + shown(w) +
           "; export the surface anew");
    return value;
  }

  /// Text for a message: printable and short.
  static std::string shown(std::string_view text) {
    constexpr std::size_t kReadable = 40;
    if (text.empty()) return "missing";
    std::string out = "'";
    for (const char c : text.substr(0, kReadable)) out += c < 0x20 || c == 0x7F ? '?' : c;
    return out + (text.size() > kReadable ? "...'" : "'");
  }
  std::size_t at() const { return at_; }
  int line() const { return line_; }

 private:
  static bool is_space(char c) { return c == ' ' || c == '\t' || c == '\r'; }
  void skip_space() {
    std::size_t n = 0;
    while (n < rest_.size() && is_space(rest_[n])) ++n;
    rest_.remove_prefix(n);
  }

  std::string_view text_, rest_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 0;
};

/// A polygon's corners as a fan of triangles.
template <class Corners, class Triangles>
void add_fan(const Corners& corners, Triangles& triangles) {
  for (std::size_t i = 2; i < corners.size(); ++i)
    triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

}  // namespace feltwire::mesh_text

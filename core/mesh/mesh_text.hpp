#pragma once
// Internal to the mesh files: reads a text line by line and word by word. Errors name the line.

#include <array>
#include <charconv>
#include <cmath>
#include <cstdio>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/file_error.hpp"
#include "core/base/types.hpp"

namespace feltwire::mesh_text {

/// [m] The largest coordinate of a scene.
inline constexpr double kFarthest = 1e6;

/// The error of vertex `number` (from 1), if it has one. `scale`: metres per unit.
inline std::optional<std::string> broken_vertex(std::size_t number, const Vec3& v, double scale) {
  for (Eigen::Index axis = 0; axis < 3; ++axis) {
    const std::string which =
        "vertex " + std::to_string(number) + ": " + "xyz"[axis] + std::string(": ");
    if (!std::isfinite(v[axis])) return which + "is not finite; export the surface anew";
    if (std::abs(v[axis] * scale) <= kFarthest) continue;
    std::array<char, 96> text{};
    std::snprintf(text.data(), text.size(),
                  "must lie within %g m of the origin, is %.6g with a scale of %g m; ", kFarthest,
                  v[axis], scale);
    return which + text.data() + "check scale or unit, or remove the vertex";
  }
  return std::nullopt;
}

/// Compares a word with one in small letters. Programs write both.
inline bool is_word(std::string_view word, std::string_view lower) {
  if (word.size() != lower.size()) return false;
  for (std::size_t i = 0; i < word.size(); ++i) {
    const char c = word[i];
    if ((c >= 'A' && c <= 'Z' ? static_cast<char>(c - 'A' + 'a') : c) != lower[i]) return false;
  }
  return true;
}

/// Cuts a text into lines, and lines into words at white space. A line ends with a line feed. In a
/// file whose first line ends with a carriage return alone, all lines end so.
class TokenReader {
 public:
  /// `continued`: a backslash at the end of a line joins the next one to it.
  TokenReader(std::string_view text, const std::string& name, bool continued = false)
      : text_(text), name_(name), continued_(continued) {
    const std::size_t end = text_.find_first_of("\r\n");
    if (end != std::string_view::npos && text_[end] == '\r' && text_.substr(end + 1, 1) != "\n")
      line_end_ = '\r';
  }

  [[noreturn]] void fail(const std::string& message) const { fail_at(line_, message); }
  [[noreturn]] void fail_at(int line, const std::string& message) const {
    throw FileError(name_ + ":" + std::to_string(line) + ": " + message);
  }

  /// Goes to the next line that is not empty; false at the end. Skips the rest of the line before,
  /// with the lines that continue it.
  bool next_line() {
    while (goes_on_) cut_line();
    while (at_ < text_.size()) {
      cut_line();
      skip_space();
      if (!rest_.empty()) return true;
    }
    rest_ = {};
    return false;
  }
  /// Ends the line here, also where a backslash would continue it: the rest is a comment.
  void end_line() {
    rest_ = {};
    goes_on_ = false;
  }

  /// The next word of the line; empty at the line's end.
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
           "; export the surface anew" +
           (written.find(',') != std::string_view::npos ? " with a decimal point" : ""));
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
  static bool is_space(char c) {
    return c == ' ' || c == '\t' || c == '\r' || c == '\v' || c == '\f';
  }
  void skip_space() {
    for (;;) {
      std::size_t n = 0;
      while (n < rest_.size() && is_space(rest_[n])) ++n;
      rest_.remove_prefix(n);
      if (!rest_.empty() || !goes_on_) return;
      cut_line();
    }
  }
  /// Takes the next line of the text, without the backslash that continues it.
  void cut_line() {
    goes_on_ = false;
    rest_ = {};
    if (at_ >= text_.size()) return;
    std::size_t end = text_.find(line_end_, at_);
    if (end == std::string_view::npos) end = text_.size();
    rest_ = text_.substr(at_, end - at_);
    at_ = end + 1;
    ++line_;
    if (!continued_) return;
    std::string_view line = rest_;
    while (!line.empty() && line.back() == '\r') line.remove_suffix(1);
    if (line.empty() || line.back() != '\\') return;
    line.remove_suffix(1);
    rest_ = line;
    goes_on_ = true;
  }

  std::string_view text_, rest_;
  const std::string& name_;
  std::size_t at_ = 0;
  int line_ = 0;
  char line_end_ = '\n';
  bool continued_ = false;
  bool goes_on_ = false;  // the next line belongs to this one
};

/// A polygon's corners as a fan of triangles.
template <class Corners, class Triangles>
void add_fan(const Corners& corners, Triangles& triangles) {
  for (std::size_t i = 2; i < corners.size(); ++i)
    triangles.push_back({corners[0], corners[i - 1], corners[i]});
}

}  // namespace feltwire::mesh_text

#pragma once
// Internal to json_document.cpp: the structure of a JSON text with the line of every value.
//
// FlatBuffers' own parser is not used. It names no field in an error, reads one token ahead and so
// sometimes names a wrong line, and accepts text that is not JSON (nan, numbers in quotes, calls of
// functions). This parser accepts JSON, and three common additions: // and /* */ comments, a comma
// after the last element, and keys without quotes.

#include <algorithm>
#include <charconv>
#include <set>
#include <string>
#include <string_view>
#include <vector>

#include "core/base/foreign_content.hpp"
#include "core/base/json_document.hpp"
#include "flatbuffers/util.h"

namespace feltwire::json {

struct Node {
  enum class Kind { object, array, string, number, word };
  Kind kind = Kind::word;
  int line = 1;       // where the value begins, from 1
  std::string key;    // in an object; in an array that stands for a struct, its field's name
  std::string text;   // string: between the quotes, escapes as written; number, word: as written
  double number = 0;  // finite
  std::vector<Node> children;
};

inline constexpr int kMaxDepth = 32;

/// "file:line: field: message"
inline std::string error_text(const std::string& file, int line, std::string_view path,
                              std::string_view message) {
  return file + ":" + std::to_string(line) + ": " +
         (path.empty() ? std::string("document") : std::string(path)) + ": " + std::string(message);
}

/// Text for an error message: without control characters, cut to a readable length.
inline std::string shown(std::string_view text) {
  constexpr std::size_t kReadable = 40;
  std::size_t end = std::min(kReadable, text.size());
  while (end > 0 && end < text.size() && (text[end] & 0xC0) == 0x80) --end;  // no half characters
  std::string out = "'";
  for (const char c : text.substr(0, end))
    out += static_cast<unsigned char>(c) < 0x20 || c == 0x7F ? '?' : c;
  return out + (end < text.size() ? "...'" : "'");
}

inline bool is_digit(char c) { return c >= '0' && c <= '9'; }
inline bool is_letter(char c) {
  return (c >= 'a' && c <= 'z') || (c >= 'A' && c <= 'Z') || c == '_';
}
inline bool is_hex(char c) {
  return is_digit(c) || (c >= 'a' && c <= 'f') || (c >= 'A' && c <= 'F');
}

/// If a text is in a notation that is taken for JSON now and then: which, and the remedy; else
/// null. `text` begins where a value should.
inline const char* other_notation(std::string_view text) {
  constexpr const char* kYaml =
      "is YAML, not JSON; convert it, for example with yq -o json FILE, or write { \"name\": ... }";
  constexpr const char* kToml = "is TOML or an INI file, not JSON; write { \"name\": ... }";
  if (text.starts_with('<'))
    return "is XML, not JSON; a scene names an MJCF or URDF file: \"mjcf\": { \"file\": \"...\" }";
  if (text.starts_with("---") || text.starts_with("%YAML") || text.starts_with("- ")) return kYaml;
  const bool comment = text.starts_with('#');
  while (text.starts_with('#') || (comment && text.starts_with('\n'))) {
    text.remove_prefix(std::min(text.find('\n'), text.size()));
    text.remove_prefix(std::min(text.find_first_not_of(" \t\r\n"), text.size()));
  }
  const char* unknown = comment ? "begins with '#'; a comment in JSON begins with //" : nullptr;
  if (comment && (text.starts_with("---") || text.starts_with("- "))) return kYaml;
  if (comment && text.starts_with('[')) return kToml;
  const bool quoted = text.starts_with('"') || text.starts_with('\'');
  if (text.empty() || (!quoted && !is_letter(text.front()))) return unknown;
  std::size_t end = 1;
  while (end < text.size() && text[end] != '\n' &&
         (quoted ? text[end] != text.front()
                 : is_letter(text[end]) || is_digit(text[end]) || text[end] == '-' ||
                       text[end] == '.'))
    ++end;
  text.remove_prefix(std::min(end + (quoted ? 1 : 0), text.size()));
  text.remove_prefix(std::min(text.find_first_not_of(" \t"), text.size()));
  if (text.starts_with(':')) return kYaml;
  return text.starts_with('=') ? kToml : unknown;
}

class Scanner {
 public:
  Scanner(std::string_view text, const std::string& file) : text_(text), file_(file) {}

  Node document() {
    if (const auto foreign = foreign_content(text_)) fail(*foreign);
    at_ = text_.size() - without_byte_order_mark(text_).size();
    skip_space();
    if (done()) fail("there is nothing in it; write an object { ... }");
    if (const char* other = other_notation(text_.substr(at_))) fail(other);
    Node root = value(0);
    skip_space();
    if (!done()) fail("text goes on after the document has ended; remove it");
    return root;
  }

 private:
  [[noreturn]] void fail(std::string_view message) const {
    throw FileError(error_text(file_, line_, path_, message));
  }

  bool done() const { return at_ >= text_.size(); }
  char next() const { return done() ? '\0' : text_[at_]; }
  std::string here() const { return done() ? "the end of the file" : shown(text_.substr(at_, 1)); }

  void skip_space() {
    while (!done()) {
      const char c = text_[at_];
      if (c == '\n') ++line_;
      if (c == ' ' || c == '\t' || c == '\r' || c == '\n') {
        ++at_;
      } else if (text_.substr(at_, 2) == "//") {
        while (!done() && text_[at_] != '\n') ++at_;
      } else if (text_.substr(at_, 2) == "/*") {
        const auto end = text_.find("*/", at_ + 2);
        if (end == std::string_view::npos) fail("a comment /* is never closed; add */");
        for (; at_ < end + 2; ++at_) line_ += text_[at_] == '\n';
      } else {
        return;
      }
    }
  }

  Node value(int depth) {
    if (depth > kMaxDepth)
      fail("is nested deeper than " + std::to_string(kMaxDepth) + " levels; flatten it");
    Node node;
    node.line = line_;
    const char c = next();
    if (c == '{') {
      node.kind = Node::Kind::object;
      members(node, depth);
    } else if (c == '[') {
      node.kind = Node::Kind::array;
      elements(node, depth);
    } else if (c == '"') {
      node.kind = Node::Kind::string;
      node.text = string();
    } else if (is_digit(c) || c == '-') {
      node.kind = Node::Kind::number;
      number(node);
    } else if (is_letter(c)) {
      node.text = word();
    } else {
      fail("expected a value, found " + here() + "; write a number, a text in quotes, [ or {");
    }
    return node;
  }

  void members(Node& object, int depth) {
    const int opened = line_;
    std::set<std::string> keys;
    ++at_;
    for (skip_space(); next() != '}' || done(); skip_space()) {
      const std::size_t outer = path_.size();
      std::string key;
      if (next() == '"') {
        key = string();
      } else if (is_letter(next())) {
        key = word();
      } else {
        unclosed(opened, '}', "a field name");
      }
      if (outer > 0) path_ += '.';
      path_ += printable_key(key);
      if (!keys.insert(key).second) fail("stands twice here; keep one");
      skip_space();
      if (next() != ':') fail("expected ':' after the field name, found " + here() + "; add it");
      ++at_;
      skip_space();
      object.children.push_back(value(depth + 1));
      object.children.back().key = std::move(key);
      path_.resize(outer);
      skip_space();
      if (!separator('}')) unclosed(opened, '}', "',' or '}'");
    }
    ++at_;
  }

  void elements(Node& array, int depth) {
    const int opened = line_;
    ++at_;
    for (skip_space(); next() != ']' || done(); skip_space()) {
      const std::size_t outer = path_.size();
      path_ += '[' + std::to_string(array.children.size()) + ']';
      if (done()) unclosed(opened, ']', "a value");
      array.children.push_back(value(depth + 1));
      path_.resize(outer);
      skip_space();
      if (!separator(']')) unclosed(opened, ']', "',' or ']'");
    }
    ++at_;
  }

  /// After a member: takes a comma; the loop takes the closing bracket.
  bool separator(char close) {
    if (next() == ',') {
      ++at_;
      return true;
    }
    return !done() && next() == close;
  }

  [[noreturn]] void unclosed(int opened, char close, const char* expected) const {
    if (!done()) fail(std::string("expected ") + expected + ", found " + here() + "; correct it");
    fail(std::string("the file ends before the '") + close + "' to the bracket of line " +
         std::to_string(opened) + "; add it");
  }

  static std::string printable_key(const std::string& key) {
    const std::string q = shown(key);
    return q.substr(1, q.size() - 2);
  }

  std::string word() {
    const std::size_t begin = at_;
    while (is_letter(next()) || is_digit(next())) ++at_;
    return std::string(text_.substr(begin, at_ - begin));
  }

  std::string string() {
    const std::size_t begin = ++at_;
    while (true) {
      const char c = next();
      if (done() || c == '\n') fail("a text in quotes is not closed on its line; add \"");
      if (c == '"') break;
      if (static_cast<unsigned char>(c) < 0x20)
        fail("a control character stands in a text; write it as \\u00..");
      if (c == '\\') {
        escape();
      } else {
        utf8();
      }
    }
    return std::string(text_.substr(begin, at_++ - begin));
  }

  void escape() {
    ++at_;
    const char c = next();
    ++at_;
    if (c == 'u') {
      for (int i = 0; i < 4; ++i, ++at_)
        if (!is_hex(next())) fail("\\u in a text needs four hexadecimal digits; complete it");
    } else if (c == '\0' || std::string_view("\"\\/bfnrt").find(c) == std::string_view::npos) {
      fail("a text holds an unknown escape; write \\\\ for a backslash");
    }
  }

  void utf8() {
    // FromUTF8 reads as many bytes as the first byte says: give it an invalid end.
    const std::string character(text_.substr(at_, 4));
    const char* end = character.c_str();
    if (flatbuffers::FromUTF8(&end) < 0) fail("a text is not UTF-8; save the file as UTF-8");
    at_ += static_cast<std::size_t>(end - character.c_str());
  }

  void digits() {
    if (!is_digit(next())) fail("a number is incomplete; write it like -12.5e-3");
    while (is_digit(next())) ++at_;
  }

  void number(Node& node) {
    const std::size_t begin = at_;
    if (next() == '-') ++at_;
    if (next() == '0') {
      ++at_;
      if (is_digit(next())) fail("a number begins with a needless 0; remove it");
    } else {
      digits();
    }
    if (next() == '.') {
      ++at_;
      digits();
    }
    if (next() == 'e' || next() == 'E') {
      ++at_;
      if (next() == '+' || next() == '-') ++at_;
      digits();
    }
    if (is_letter(next()) || next() == '.')
      fail("a number is followed by " + here() + "; write plain decimal digits");
    node.text = std::string(text_.substr(begin, at_ - begin));
    const char* end = node.text.data() + node.text.size();
    const auto read = std::from_chars(node.text.data(), end, node.number);
    if (read.ec != std::errc{} || read.ptr != end)
      fail("the number " + shown(node.text) + " is too large or too small for a double; change it");
  }

  std::string_view text_;
  const std::string& file_;
  std::size_t at_ = 0;
  int line_ = 1;
  std::string path_;
};

/// Throws FileError at the first byte that does not fit.
inline Node outline(std::string_view text, const std::string& file) {
  return Scanner(text, file).document();
}

}  // namespace feltwire::json

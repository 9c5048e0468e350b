#pragma once
// A JSON file read against a FlatBuffers schema, with errors that name the file, the line and the
// field.

#include <cstdint>
#include <filesystem>
#include <memory>
#include <optional>
#include <string>
#include <string_view>

#include "core/base/enum_names.hpp"
#include "core/base/file_error.hpp"

namespace feltwire {

/// Returns the file's whole text. Throws FileError if it cannot be read.
std::string read_text(const std::filesystem::path& file);

class JsonDocument {
 public:
  /// Parses `json` against `schema` (the text of a .fbs file with a root_type). Syntax errors,
  /// unknown, repeated, missing and mistyped fields throw FileError with the line. `file` is what
  /// errors call it.
  JsonDocument(std::string_view json, std::string file, const char* schema);
  ~JsonDocument();
  JsonDocument(const JsonDocument&) = delete;
  JsonDocument& operator=(const JsonDocument&) = delete;

  /// The FlatBuffer, built here from checked text; lives as long as this.
  const std::uint8_t* buffer() const;

  /// Whether the text has a value at a path like "objects[2].sphere".
  bool has(std::string_view path) const;
  /// The number at a path. Empty if there is none.
  std::optional<double> number(std::string_view path) const;

  /// The line (from 1) on which the value at a path like "objects[2].sphere.radius" begins. If the
  /// path is not in the text (a defaulted field), the line of its nearest parent.
  int line_of(std::string_view path) const;

  /// Throws FileError "file:line: path: message".
  [[noreturn]] void fail(std::string_view path, std::string_view message) const;

  /// The value of an enum by its name at a path; `names` has one for each value. Throws FileError
  /// that lists them.
  template <class Enum, class Names>
  Enum choice(std::string_view path, std::string_view given, const Names& names) const {
    const auto* const found = find_named(names, given);
    if (found == nullptr)
      fail(path, "is '" + std::string(given) + "'; choose one of: " + joined_names(names, " "));
    return static_cast<Enum>(found - std::data(names));
  }

 private:
  struct Parsed;
  std::unique_ptr<Parsed> parsed_;
};

}  // namespace feltwire

#pragma once
// Tables and files of the lab: a text is built first and then written at once.

#include <array>
#include <cstdio>
#include <filesystem>
#include <string>

namespace feltwire {

/// Appends the text that printf would print; at most 255 characters.
template <class... Values>
void append(std::string& text, const char* format, Values... values) {
  std::array<char, 256> buffer;
  std::snprintf(buffer.data(), buffer.size(), format, values...);
  text += buffer.data();
}

/// Writes a whole file. Throws std::runtime_error that names the file and the remedy.
void write_text(const std::filesystem::path& file, const std::string& text);

}  // namespace feltwire

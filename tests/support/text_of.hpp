#pragma once

#include <filesystem>
#include <fstream>
#include <sstream>
#include <string>

namespace feltwire::test {

/// The text of a whole file; empty if there is none.
inline std::string text_of(const std::filesystem::path& file) {
  std::ifstream in(file);
  std::ostringstream text;
  text << in.rdbuf();
  return text.str();
}

}  // namespace feltwire::test

#pragma once
// Checks of a program's help text.

#include <gtest/gtest.h>

#include <filesystem>
#include <regex>
#include <sstream>
#include <string>
#include <vector>

#include "tests/support/program.hpp"

namespace feltwire::test {

/// Checks that a help text fits on a screen: 45 lines of 100 characters.
inline void expect_one_screen(const std::string& help) {
  constexpr std::size_t kLines = 45, kWidth = 100;
  std::istringstream text(help);
  std::size_t lines = 0;
  for (std::string line; std::getline(text, line); ++lines) EXPECT_LE(line.size(), kWidth) << line;
  EXPECT_LE(lines, kLines) << help;
}

/// Checks that each input file in the examples of a help text is in the repository. Returns how
/// many there were. A word in capitals (FILE) is not a file name.
inline int expect_files_of_examples(const std::string& program,
                                    const std::vector<std::string>& command) {
  std::vector<std::string> words = command;
  words.emplace_back("--help");
  const Outcome help = Program(program, words).finish();
  EXPECT_EQ(help.status, 0) << help.error;
  const std::regex input(R"(feltwire-\w+ [^\n]*)");
  const std::regex file(R"(--(?:scene|config|explain|mesh)[ =]([\w./-]+\.\w+))");
  int named = 0;
  for (std::sregex_iterator line(help.out.begin(), help.out.end(), input), end; line != end;
       ++line) {
    const std::string text = line->str();
    for (std::sregex_iterator at(text.begin(), text.end(), file); at != end; ++at, ++named)
      EXPECT_TRUE(
          std::filesystem::exists(std::filesystem::path(FELTWIRE_SOURCE_DIR) / (*at)[1].str()))
          << text << ": " << (*at)[1] << " is not in the repository";
  }
  return named;
}

}  // namespace feltwire::test

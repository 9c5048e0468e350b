#pragma once
// Options of a program from its environment, for where a command line is awkward (containers).

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <string>

namespace feltwire {

/// Lets every option of `app` that the command line does not give be given by a variable:
/// --busy-poll by FELTWIRE_BUSY_POLL. Call when all options are there. --help, and options without
/// a long name, have none.
inline void read_environment(CLI::App& app) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty() || option == app.get_help_ptr()) continue;
    std::string name = "FELTWIRE_" + option->get_lnames().front();
    std::transform(name.begin(), name.end(), name.begin(), [](unsigned char letter) {
      return letter == '-' ? '_' : static_cast<char>(std::toupper(letter));
    });
    option->envname(name);
  }
}

}  // namespace feltwire

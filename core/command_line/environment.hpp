#pragma once
// Reads options of a program from its environment, for places where a command line is awkward
// (containers).

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <string>

namespace feltwire {

/// Lets an environment variable set every option of `app` that is missing on the command line:
/// FELTWIRE_BUSY_POLL sets --busy-poll. Call it after all options were added. --help, and options
/// without a long name, have none.
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

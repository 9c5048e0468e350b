#pragma once
// Two helps of a program with many options: --help on one screen, --help-all with every option.

#include <CLI/CLI.hpp>
#include <algorithm>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// An option of the short help. `text` fits on its line: 68 characters.
struct ShownOption {
  std::string_view name;  // without the two dashes
  std::string text;
};

/// The short help, and the lines after its options.
struct ShortHelp {
  std::vector<ShownOption> options;
  std::string footer;
};

inline void add_helps(CLI::App& app) {
  app.set_help_flag("-h,--help", "Print the options that most users need, and exit");
  app.set_help_all_flag("--help-all", "Print all options, and exit");
}

/// Prints as CLI11's exit() does, and returns its exit status. For --help only the options of
/// `help` are left, with their short texts, and without their variables. `app` has add_helps().
inline int exit_with(CLI::App& app, const CLI::Error& error, const ShortHelp& help) {
  if (error.get_name() != "CallForHelp") return app.exit(error);
  for (CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty()) continue;
    const auto shown =
        std::ranges::find(help.options, option->get_lnames().front(), &ShownOption::name);
    const bool ends = option == app.get_help_ptr() || option == app.get_help_all_ptr() ||
                      option == app.get_version_ptr();
    option->envname("")->group(ends || shown != help.options.end() ? "Options" : "");
    if (shown != help.options.end()) option->description(shown->text);
  }
  app.footer(help.footer);
  return app.exit(error);
}

}  // namespace feltwire

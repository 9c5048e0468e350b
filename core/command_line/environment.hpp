#pragma once
// Reads options of a program from its environment, for places where a command line is awkward
// (containers).

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cctype>
#include <cstdlib>
#include <functional>
#include <initializer_list>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

namespace feltwire {

/// An option that, on the command line, drops another one from the environment: the program would
/// refuse both together, and the command line decides. Names are without the two dashes.
struct Rival {
  using When = std::function<bool(std::string_view value)>;

  std::string given;    // on the command line
  std::string dropped;  // where only the environment gives it
  When when = {};       // only where the value of `given` is so. Empty: every value
  When unless = {};     // not where the value of `dropped` is so. Empty: no exception
};
using Rivals = std::vector<Rival>;

/// Each of these options, on the command line, drops all others from the environment.
inline Rivals exclusive(std::initializer_list<const char*> names) {
  Rivals rivals;
  for (const char* given : names)
    for (const char* dropped : names)
      if (given != dropped) rivals.push_back({given, dropped});
  return rivals;
}

/// FELTWIRE_BUSY_POLL of busy-poll.
inline std::string environment_name(std::string_view option) {
  std::string name = "FELTWIRE_" + std::string(option);
  std::transform(name.begin(), name.end(), name.begin(), [](unsigned char letter) {
    return letter == '-' ? '_' : static_cast<char>(std::toupper(letter));
  });
  return name;
}

/// The option with this long name; null: there is none. CLI11's own search ends the program if
/// there is no memory.
inline const CLI::Option* option_of(const CLI::App& app, std::string_view name) {
  for (const CLI::Option* option : app.get_options()) {
    const std::vector<std::string>& names = option->get_lnames();
    if (std::find(names.begin(), names.end(), name) != names.end()) return option;
  }
  return nullptr;
}

/// The value of an option of `app` on the command line, nothing where it is not given. The last one
/// counts. A flag has the value true, or false where its other name was given, as --no-local-model.
inline std::optional<std::string> value_on_command_line(const CLI::App& app, int argc,
                                                        const char* const* argv,
                                                        const std::string& name) {
  std::optional<std::string> value;
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("--")) continue;
    const std::string said = word.substr(2, word.find('=') - 2);
    const CLI::Option* option = option_of(app, said);
    if (option == nullptr) continue;
    const bool attached = word.find('=') != std::string::npos;
    // The word after an option is its value, also where it looks like an option.
    const bool follows = !attached && option->get_items_expected_min() > 0 && i + 1 < argc;
    if (follows) ++i;
    if (option != option_of(app, name)) continue;
    if (follows || attached)
      value = follows ? argv[i] : word.substr(word.find('=') + 1);
    else
      value = said == option->get_lnames().front() ? "true" : "false";
  }
  return value;
}

/// Lets an environment variable set every option of `app` that is missing on the command line:
/// FELTWIRE_BUSY_POLL sets --busy-poll. Call it after all options were added. Options without a
/// long name have no variable, and neither has --help, --version, or an option of `ending`: they
/// end the program, and one that is forgotten in the environment would always do so. An option of
/// the command line drops its `rivals` from the environment.
inline void read_environment(CLI::App& app, int argc, const char* const* argv,
                             const Rivals& rivals = {},
                             std::initializer_list<const char*> ending = {}) {
  for (CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty() || option == app.get_help_ptr() ||
        option == app.get_version_ptr())
      continue;
    const std::string& name = option->get_lnames().front();
    if (std::find(ending.begin(), ending.end(), name) == ending.end())
      option->envname(environment_name(name));
  }
  for (const Rival& rival : rivals) {
    const auto given = value_on_command_line(app, argc, argv, rival.given);
    if (!given || (rival.when && !rival.when(*given))) continue;
    const char* set = std::getenv(environment_name(rival.dropped).c_str());
    if (set != nullptr && rival.unless && rival.unless(set)) continue;
    app.get_option("--" + rival.dropped)->envname("");
  }
}

}  // namespace feltwire

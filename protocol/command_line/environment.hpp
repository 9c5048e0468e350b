#pragma once
// Reads options of a program from its environment, for places where a command line is awkward
// (containers).

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <cctype>
#include <cstdlib>
#include <functional>
#include <initializer_list>
#include <optional>
#include <stdexcept>
#include <string>
#include <string_view>
#include <utility>
#include <vector>

#include "protocol/command_line/suggestion.hpp"

namespace feltwire {

/// Every program that joins a server reads these: where the server is, whom to trust, and the
/// client's own credentials.
inline constexpr std::array<std::string_view, 8> kSharedVariables = {
    "FELTWIRE_CONNECT", "FELTWIRE_FINGERPRINT", "FELTWIRE_FINGERPRINT_FILE", "FELTWIRE_CA",
    "FELTWIRE_TOKEN",   "FELTWIRE_TOKEN_FILE",  "FELTWIRE_CERTIFICATE",      "FELTWIRE_KEY"};

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

/// An option that has another spelling now: {"map-scale", "--device KIND:map_scale=..."}. It may be
/// one value of an option: {"local-model=true", "--local-model whole"}.
struct RenamedOption {
  std::string old;  // without the two dashes
  std::string now;  // as on a command line
};
using Renamed = std::vector<RenamedOption>;

/// Throws std::invalid_argument with the new spelling if `option` (without dashes) is an old one.
/// `written`: as the user wrote it.
inline void refuse_renamed(const Renamed& renamed, std::string_view option,
                           std::string_view written) {
  const auto found = std::ranges::find(renamed, option, &RenamedOption::old);
  if (found != renamed.end())
    throw std::invalid_argument(std::string(written) + " is an old spelling; write " + found->now);
}

/// The environment variables of a program's options.
struct Variables {
  /// "server": FELTWIRE_SERVER_BUSY_POLL sets --busy-poll. Empty: only `shared` options have one.
  std::string program = {};
  /// Options whose variable several programs share, and that variable: {"ca", "FELTWIRE_CA"}.
  std::vector<std::pair<std::string, std::string>> shared = {};
  /// Options that end the program. They have no variable: a forgotten one would always end it.
  std::vector<std::string> ending = {};
  /// Options with another spelling now. Neither their old spelling nor its variable is read.
  Renamed renamed = {};
};

/// "PREFIX" and an option in capitals: FELTWIRE_BUSY_POLL of FELTWIRE_ and busy-poll.
inline std::string in_capitals(std::string prefix, std::string_view option) {
  for (const char letter : option)
    prefix += letter == '-' ? '_' : static_cast<char>(std::toupper(letter));
  return prefix;
}

/// The variable of an option; empty: it has none.
inline std::string variable_of(const Variables& variables, std::string_view option) {
  for (const auto& [name, variable] : variables.shared)
    if (name == option) return variable;
  if (variables.program.empty() || std::ranges::count(variables.ending, option) > 0) return {};
  return in_capitals(in_capitals("FELTWIRE_", variables.program) + "_", option);
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

/// Throws std::invalid_argument for a word of the command line that is an old spelling.
inline void check_words(const CLI::App& app, int argc, const char* const* argv,
                        const Renamed& renamed) {
  for (int i = 1; i < argc && std::string_view(argv[i]) != "--"; ++i) {
    const std::string word = argv[i];
    if (!word.starts_with("--")) continue;
    const std::size_t equals = word.find('=');
    const std::string name = word.substr(2, equals - 2);
    const CLI::Option* option = option_of(app, name);
    if (option == nullptr) {
      refuse_renamed(renamed, name, "--" + name);
    } else if (equals != std::string::npos) {
      refuse_renamed(renamed, word.substr(2), word);
    } else if (option->get_items_expected_min() > 0) {
      // The word after an option is its value, also where it looks like an option.
      if (++i < argc) refuse_renamed(renamed, name + "=" + argv[i], "--" + name + " " + argv[i]);
    }
  }
}

/// The value of an option of `app` on the command line, nothing where it is not given. The last one
/// counts. A flag has the value true, or false where its other name was given, as --no-rehearsal.
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
    else if (option->get_items_expected_min() == 0)
      value = said == option->get_lnames().front() ? "true" : "false";
  }
  return value;
}

/// Throws std::invalid_argument for a variable that sets an option of `app` to nothing.
inline void refuse_empty_variables(const CLI::App& app) {
  for (const CLI::Option* option : app.get_options()) {
    const std::string& name = option->get_envname();
    const char* const value = name.empty() ? nullptr : std::getenv(name.c_str());
    if (value != nullptr && *value == '\0')
      throw std::invalid_argument(name + " is empty; unset it, or give it a value");
  }
}

/// Throws std::invalid_argument for a variable of an option with another spelling now.
inline void refuse_renamed_variables(const Variables& variables) {
  const std::string own = in_capitals("FELTWIRE_", variables.program) + "_";
  for (const RenamedOption& option : variables.renamed) {
    const std::size_t equals = option.old.find('=');
    const std::string name = in_capitals(own, option.old.substr(0, equals));
    const char* const value = std::getenv(name.c_str());
    if (value == nullptr) continue;
    if (equals == std::string::npos)
      refuse_renamed(variables.renamed, option.old, name);
    else if (option.old.substr(equals + 1) == value)
      refuse_renamed(variables.renamed, option.old, name + "=" + value);
  }
}

/// Throws std::invalid_argument for a variable of this program that is a misspelled option of `app`
/// (FELTWIRE_SERVER_PROT), and for one that is spelled as before programs had their own
/// (FELTWIRE_PORT), is empty, or is the variable of an option with another spelling now.
inline void check_variables(const CLI::App& app, const Variables& variables) {
  refuse_empty_variables(app);
  if (variables.program.empty()) return;
  std::vector<std::string> known;  // without what all names begin with
  for (const CLI::Option* option : app.get_options()) {
    if (option->get_lnames().empty()) continue;
    known.push_back(in_capitals("", option->get_lnames().front()));
    const std::string old = "FELTWIRE_" + known.back(), now = option->get_envname();
    const bool renamed = !now.empty() && std::ranges::count(kSharedVariables, old) == 0;
    if (renamed && std::getenv(old.c_str()) != nullptr && std::getenv(now.c_str()) == nullptr)
      throw std::invalid_argument(old + " is " + now +
                                  " now, since each program has variables of its own; rename it");
  }
  refuse_renamed_variables(variables);
  const std::string own = in_capitals("FELTWIRE_", variables.program) + "_";
  for (char** entry = environ; *entry != nullptr; ++entry) {
    const std::string_view text(*entry);
    const std::string name(text.substr(0, text.find('=')));
    if (!name.starts_with(own)) continue;
    const std::string option = name.substr(own.size());
    if (std::ranges::count(known, option) > 0) continue;
    // Others may set variables of this kind: Kubernetes sets FELTWIRE_SERVER_SERVICE_HOST.
    if (const std::string meant = nearest(option, known); !meant.empty())
      throw std::invalid_argument("the environment has " + name +
                                  ", which is no option; did you mean " + own + meant + "?");
  }
}

/// Lets an environment variable set every option of `app` that is missing on the command line:
/// FELTWIRE_SERVER_BUSY_POLL sets --busy-poll of the server. Call it after all options were added.
/// Options without a long name have no variable, and neither has --help, --version, or an option
/// that ends the program. An option of the command line drops its `rivals` from the environment.
/// Throws std::invalid_argument as check_variables() does.
inline void read_environment(CLI::App& app, int argc, const char* const* argv,
                             const Variables& variables, const Rivals& rivals = {}) {
  for (CLI::Option* option : app.get_options())
    if (!option->get_lnames().empty() && option != app.get_help_ptr() &&
        option != app.get_help_all_ptr() && option != app.get_version_ptr())
      option->envname(variable_of(variables, option->get_lnames().front()));
  check_variables(app, variables);
  for (const Rival& rival : rivals) {
    const auto given = value_on_command_line(app, argc, argv, rival.given);
    if (!given || (rival.when && !rival.when(*given))) continue;
    const char* set = std::getenv(variable_of(variables, rival.dropped).c_str());
    if (set != nullptr && rival.unless && rival.unless(set)) continue;
    app.get_option("--" + rival.dropped)->envname("");
  }
}

}  // namespace feltwire

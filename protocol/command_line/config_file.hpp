#pragma once
// Options of a program from a configuration file: the same options as on its command line.

#include <CLI/CLI.hpp>
#include <filesystem>
#include <functional>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/command_line/environment.hpp"

namespace feltwire {

/// A member of a configuration file, and the option that it sets.
struct ConfigEntry {
  std::string field;               // the member's name
  std::string option;              // the same with '-' for '_'; an option in the plural is repeated
  int line = 1;                    // of the value, from 1
  std::vector<std::string> words;  // the same on a command line
};

/// The contents of a program's configuration file.
struct ConfigFile {
  std::string path;
  std::vector<ConfigEntry> entries;

  /// `message`, which names options as on a command line, with the file and line of the first one
  /// that is in this file: "hand.json:3: rate: --rate must be from 10 to 100000 Hz". If it names
  /// none, the file comes last.
  std::string located(const std::string& message) const;
};

/// Returns the value of an option in a file of this folder as on a command line: relative paths
/// begin at the folder. Throws std::invalid_argument with what is wrong with the value.
using FileValue = std::function<std::string(std::string_view option, const std::string& value,
                                            const std::filesystem::path& folder)>;

/// A FileValue whose relative paths are those of `options`.
FileValue files_in_folder(std::vector<std::string> options);

/// Reads a configuration file of `app`, an object in JSON: {"rate": 100, "rehearsal": false,
/// "trust_robot": [0.1, 5]}. A number may be written as text, as "inf" must be. An option that
/// may be repeated (CLI::MultiOptionPolicy::TakeAll) is a list, and in the plural: "scenes".
/// `command_line`: options that a file cannot set, as those that end the program. `file`: the name
/// of the file. `renamed`: options with another spelling now. Call it after all options were added.
/// Throws FileError "file:line: field: what is wrong".
ConfigFile read_config(const CLI::App& app, std::string_view json,
                       const std::filesystem::path& file,
                       const std::vector<std::string>& command_line, const FileValue& file_value,
                       const Renamed& renamed = {});

/// The value of an option on the command line, or else of its variable; nothing: neither gives it.
/// `reads_environment`: read_environment() was called. `argv[0]` is the program's name.
std::optional<std::string> given_value(const CLI::App& app, int argc, const char* const* argv,
                                       const std::string& name, bool reads_environment);

/// Reads the file that --config or its variable names; neither names one: an empty ConfigFile. A
/// token in the environment drops the file's token_file. --config itself cannot be in the file. The
/// rest as in read_config() and given_value(). A wrong file is wrong usage: throws
/// std::invalid_argument.
ConfigFile given_config(const CLI::App& app, int argc, const char* const* argv,
                        std::vector<std::string> command_line, const FileValue& file_value,
                        const Renamed& renamed, bool reads_environment);

/// The words of a command line together with those of the file. An option on the command line, or
/// whose variable is set, overrides the file; and it drops its `rivals` from the file.
/// The rest as in given_value().
std::vector<std::string> words_with_config(const CLI::App& app, int argc, const char* const* argv,
                                           const ConfigFile& file, const Rivals& rivals,
                                           bool reads_environment);

/// Parses words in the order of a command line, with the checks of strict_values.hpp. Throws
/// CLI::ParseError.
void parse_words(CLI::App& app, std::vector<std::string> words);

}  // namespace feltwire

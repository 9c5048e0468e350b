#pragma once
// The options of a server that its command line, its environment and its configuration file have.

#include <filesystem>
#include <string>
#include <string_view>

#include "server/app/server_config.hpp"

namespace CLI {
class App;
}

namespace feltwire {

/// `config` outlives `app`.
void add_config_options(CLI::App& app, ServerConfig& config);

/// A value of a configuration file as on a command line (FileValue). In a file, -1 is a busy poll
/// that never sleeps, and 0 or less no limit of a recording.
std::string server_file_value(std::string_view option, const std::string& value,
                              const std::filesystem::path& folder);

}  // namespace feltwire

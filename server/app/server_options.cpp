#include "server/app/server_options.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <stdexcept>
#include <string>
#include <vector>

#include "core/build_info/build_info.hpp"
#include "protocol/command_line/config_file.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/short_help.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "server/app/config_options.hpp"

namespace feltwire {
namespace {

/// Returns examples of command lines. Their paths are relative to the root of the repository.
std::string examples() {
  const std::string port = std::to_string(kDefaultPort);
  const std::string scene_port = std::to_string(kDefaultPort + 1);
  return R"(
Examples, typed in the root of the repository:
  feltwire-server --scene scenes/room.json
      one scene for clients on this machine: control on tcp )" +
         port + ", the scene on udp " + scene_port + R"(
  feltwire-server --scene scenes/room.json --scene scenes/workshop.json --address :: --port 9000
      two scenes on every network of this machine; needs tcp 9000 and udp 9001
  feltwire-server --scene scenes/room.json --web 6760 --demo
      a scene with two simulated hands, and its live page
  feltwire-server token add --client anna --scene room --role operator --expires 30d
      a token for another person; see feltwire-server token --help
  feltwire-server --config FILE --log-level debug
      all options from a file (docs/server.md), except the log level

When all ports are open, the server prints its fingerprint, its ports, and a command to join:
  fingerprint: 3f0e...
  listening: control tcp )" +
         port + ", scene room udp " + scene_port + R"(
  join: feltwire-client --connect 127.0.0.1:)" +
         port + R"( --scene room --fingerprint 3f0e... --token-file ...
Stop the server with Ctrl-C or SIGTERM. It informs the clients and prints a summary.
Environment variables also set options: FELTWIRE_SERVER_LOG_LEVEL sets --log-level. Options that
end the program have no variable.)";
}

ShortHelp short_help() {
  return {{{"config", "Configuration file (JSON). Options override it (docs/server.md)"},
           {"scene", "Scene file (JSON). Repeat the option for several scenes"},
           {"port", "Control port (TCP). The next port (UDP) is for the scenes. 0: free"},
           {"address", "IP address to listen on. '::': every network"},
           {"web", "PORT or ADDRESS:PORT of the live page (browser). 0: a free port"},
           {"demo", "Keep two simulated hands in each scene"},
           {"record", "FILE.mcap for a recording that feltwire-lab replay can read"},
           {"flight-recorder", "Folder for recordings of the last ten seconds before a fault"},
           {"log-level", "trace, debug, info, warning, error or off"},
           {"explain", "List the costs of this scene file with their causes, and exit"},
           {"health", "Check the server on this machine. Exit status 0: it answers"},
           {"state", "Folder of the certificate, its key and the tokens"}},
          examples() + "\nAll options: feltwire-server --help-all, docs/server.md."};
}

}  // namespace

ServerTask server_task(int argc, char** argv) {
  CLI::App app(
      "feltwire-server: renders haptic scenes. It receives hand positions over UDP and returns "
      "forces.",
      "feltwire-server");
  app.footer(examples());
  add_helps(app);
  app.set_version_flag(
      "--version", [] { return build_info("feltwire-server"); },
      "Print version, commit, compiler and build type, and exit");
  ServerTask asked;
  std::string file;
  app.add_option("--config", file,
                 "Configuration file (JSON). Options of the command line override it");
  add_config_options(app, asked.config);
  app.add_option("--summary", asked.summary,
                 "FILE.json for the counters. The server writes it at the end and at SIGUSR1");
  app.add_option("--explain", asked.explain,
                 "List the costs of this scene file and the objects that cause them, and exit");
  app.add_flag("--health", asked.health,
               "Check the server that runs with these options on this machine, and exit. Exit "
               "status 0: the server answers");
  app.add_flag("--check-config", asked.check,
               "Check the options and the files that they name, and exit. Exit status 0: a server "
               "would start with them, if its ports are free and it can write its files");
  const std::vector<std::string> ending = {"explain", "health", "check-config"};
  read_environment(app, argc, argv, {.program = "server", .ending = ending});
  const ConfigFile config =
      given_config(app, argc, argv, {"summary", "explain", "health", "check-config"},
                   server_file_value, {}, true);
  try {
    parse_words(app, words_with_config(app, argc, argv, config, {}, true));
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) std::exit(exit_with(app, error, short_help()));
    throw std::invalid_argument(config.located(error.what()) + advice(error, app) +
                                " (see --help)");
  }
  const std::string wrong = config.entries.empty() ? "" : config_error(asked.config);
  if (!wrong.empty()) throw std::invalid_argument(config.located(wrong));
  return asked;
}

}  // namespace feltwire

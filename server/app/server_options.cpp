#include "server/app/server_options.hpp"

#include <CLI/CLI.hpp>
#include <cstdlib>
#include <functional>
#include <stdexcept>
#include <type_traits>
#include <vector>

#include "core/build_info/build_info.hpp"
#include "protocol/command_line/environment.hpp"
#include "protocol/command_line/short_help.hpp"
#include "protocol/command_line/suggestion.hpp"
#include "protocol/session/profiles.hpp"

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
      two scenes on every network of this machine; needs tcp 9000, udp 9001 and udp 9002
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
           {"port", "Control port (TCP). The next UDP ports are for the scenes. 0: free"},
           {"address", "IP address to listen on. '::': every network"},
           {"web", "PORT or ADDRESS:PORT of the live page (browser). 0: a free port"},
           {"record", "FILE.mcap for a recording that feltwire-lab replay can read"},
           {"flight-recorder", "Folder for recordings of the last ten seconds before a fault"},
           {"log-level", "trace, debug, info, warning, error or off"},
           {"explain", "List the costs of this scene file with their causes, and exit"},
           {"health", "Check the server on this machine. Exit status 0: it answers"},
           {"state", "Folder of the certificate, its key and the tokens"}},
          examples() + "\nAll options: feltwire-server --help-all, docs/server.md."};
}

/// Functions that write the options of the command line over the values of the configuration file.
using Overrides = std::vector<std::function<void(ServerConfig&)>>;

/// Adds an option for a field of the configuration, or a flag if the field is a bool.
template <class Field, class Part>
CLI::Option* add(CLI::App& app, Overrides& overrides, ServerConfig& given, Field Part::*field,
                 const std::string& name, const std::string& help) {
  CLI::Option* option = nullptr;
  if constexpr (std::is_same_v<Field, bool>)
    option = app.add_flag(name, given.*field, help);
  else
    option = app.add_option(name, given.*field, help);
  overrides.push_back([option, field, &given](ServerConfig& config) {
    if (!option->empty()) config.*field = given.*field;
  });
  return option;
}

void add_serving(CLI::App& app, Overrides& overrides, ServerConfig& given) {
  using Config = ServerConfig;
  add(app, overrides, given, &Config::scenes, "--scene",
      "Scene file (JSON). Repeat the option for several scenes")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add(app, overrides, given, &Config::port, "--port",
      "Control port (TCP). The next UDP ports are for the scenes. 0: free ports")
      ->capture_default_str();
  add(app, overrides, given, &Config::address, "--address",
      "IP address to listen on. '::': every network. 0.0.0.0: every IPv4 network")
      ->capture_default_str();
  add(app, overrides, given, &Config::silence_timeout, "--silence-timeout",
      "[s] The server ends a session that sends nothing for this time")
      ->capture_default_str();
  add(app, overrides, given, &Config::profile, "--profile",
      "Network that the sessions share, " + network_profile_names() +
          ". The profile limits the datagram rate of each client");
  add(app, overrides, given, &Config::busy_poll, "--busy-poll",
      "[us] Time for which a scene's thread polls for datagrams before it sleeps. Longer polling "
      "gives faster answers and costs CPU time. inf: never sleep. This uses a whole core")
      ->capture_default_str();
  add(app, overrides, given, &Config::real_time, "--real-time",
      "Use real-time scheduling (SCHED_FIFO) for the scenes' threads, and lock the memory. This "
      "gives fewer late answers. Use it on machines that mainly serve scenes");
  add(app, overrides, given, &Config::dscp, "--dscp",
      "DSCP mark of the replies: cs0 to cs7, af11 to af43, ef, va or 0 to 63")
      ->capture_default_str();
  add(app, overrides, given, &Config::web, "--web",
      "PORT or ADDRESS:PORT of the live page, which shows the scenes in a browser. PORT alone "
      "serves this machine. ADDRESS:PORT also serves other machines, by HTTPS. 0: a free port. "
      "Default: no page");
  add(app, overrides, given, &Config::web_names, "--web-name",
      "Host name that browsers may use for the live page, in addition to IP addresses and "
      "localhost. Repeat the option for several names")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add(app, overrides, given, &Config::record, "--record",
      "FILE.mcap for a recording of all inputs and pictures of the scene. feltwire-lab replay can "
      "read it. With several scenes, each has a FILE-SCENE.mcap");
  add(app, overrides, given, &Config::record_max_mib, "--record-max-mib",
      "[MiB] Largest size of one recording file. The next files are FILE-0001.mcap, "
      "FILE-0002.mcap");
  add(app, overrides, given, &Config::record_max_seconds, "--record-max-seconds",
      "[s] Longest time in one recording file. Then the next file begins");
  add(app, overrides, given, &Config::flight_recorder, "--flight-recorder",
      "Folder for a recording of the last ten seconds of a scene. The server writes it after a "
      "session that its client did not end, after an overdrawn energy account, and at SIGUSR1");
  add(app, overrides, given, &Config::web_hands, "--web-hands",
      "Largest number of hands that viewers of the live page move at the same time, by mouse or "
      "touch. 0: none")
      ->capture_default_str();
  add(app, overrides, given, &Config::log_level, "--log-level",
      "trace, debug, info, warning, error or off")
      ->capture_default_str();
}

void add_security(CLI::App& app, Overrides& overrides, ServerConfig& given) {
  using Config = ServerConfig;
  const auto group = "Access (SECURITY.md)";
  add(app, overrides, given, &Config::state, "--state",
      "Folder of the certificate, its key and the tokens. The server creates missing files. "
      "Default: $XDG_STATE_HOME/feltwire or ~/.local/state/feltwire")
      ->group(group);
  add(app, overrides, given, &Config::certificate, "--certificate",
      "FILE (PEM) of the server's certificate. Default: from --state")
      ->group(group);
  add(app, overrides, given, &Config::key, "--key", "FILE (PEM) of the key of --certificate")
      ->group(group);
  add(app, overrides, given, &Config::client_ca, "--client-ca",
      "FILE (PEM) of authorities. Every client then also needs a certificate from one of them")
      ->group(group);
  add(app, overrides, given, &Config::tokens, "--tokens",
      "FILE of the tokens. Default: from --state")
      ->group(group);
  add(app, overrides, given, &Config::max_sessions_per_client, "--max-sessions-per-client",
      "Largest number of simultaneous sessions of one client name, over all its tokens")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::join_rate, "--join-rate",
      "[1/s] Sustained rate limit. It counts joins, parameter changes and reloads of each client, "
      "and wrong tokens from each network (IPv4 /24, IPv6 /64)")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::join_burst, "--join-burst",
      "Largest burst of the requests that --join-rate limits")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::handshake_timeout, "--handshake-timeout",
      "[s] Longest time from a connection to its valid token")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::idle_timeout, "--idle-timeout",
      "[s] The server closes a control connection that sends no request for this time")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::max_connections, "--max-connections",
      "Largest number of control connections. Half of them are reserved for clients with a valid "
      "token")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::max_connections_per_network, "--max-connections-per-network",
      "Largest number of connections from one network, in each half of --max-connections")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::handshake_rate, "--handshake-rate",
      "[1/s] Sustained rate limit of control connections from one network. Further connections "
      "wait up to 3 s")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::handshake_burst, "--handshake-burst",
      "Largest burst of the connections that --handshake-rate limits")
      ->capture_default_str()
      ->group(group);
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
  Overrides overrides;
  add_serving(app, overrides, asked.config);
  add_security(app, overrides, asked.config);
  app.add_option("--summary", asked.summary,
                 "FILE.json for the counters. The server writes it at the end and at SIGUSR1");
  app.add_option("--explain", asked.explain,
                 "List the costs of this scene file and the objects that cause them, and exit");
  app.add_flag("--health", asked.health,
               "Check the server that runs with these options on this machine, and exit. Exit "
               "status 0: the server answers");
  read_environment(app, argc, argv, {.program = "server", .ending = {"explain", "health"}});
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) std::exit(exit_with(app, error, short_help()));
    throw std::invalid_argument(error.what() + advice(error, app) + " (see --help)");
  }
  if (file.empty()) return asked;
  ServerConfig config = load_config(file);
  for (const auto& take : overrides) take(config);
  asked.config = config;
  return asked;
}

}  // namespace feltwire

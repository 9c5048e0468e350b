// feltwire-server: serves scenes to haptic clients until SIGINT or SIGTERM.

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <asio/ip/address.hpp>
#include <csignal>
#include <cstdio>
#include <filesystem>
#include <functional>
#include <string_view>

#include "core/scene/needs.hpp"
#include "protocol/profiles.hpp"
#include "protocol/secret.hpp"
#include "server/server.hpp"
#include "server/token_command.hpp"

namespace {

constexpr int kBadUsage = 2, kCannotRun = 1;

constexpr const char* kExamples = R"(
Examples:
  feltwire-server --scene scenes/wall.json
      one scene for clients on this machine: control on tcp 7400, the scene on udp 7401
  feltwire-server --scene a.json --scene b.json --address :: --port 9000
      two scenes for every network this machine is in; open tcp 9000 and udp 9001 and 9002
  feltwire-server token add --client anna --scene wall --role operator --expires 30d
      a token for somebody else, see feltwire-server token --help
  feltwire-server --config server.json --log-level debug
      everything from a file, one option from here

Once every port is open three lines say so: whom clients trust, where they find it, how one joins:
  fingerprint: 3f0e...
  listening: control tcp 7400, scene wall udp 7401
  join: feltwire-client --connect 127.0.0.1:7400 --scene wall --fingerprint 3f0e... --token-file ...
End it with Ctrl-C or SIGTERM: clients are told, and a summary is printed.)";

int fail(int status, const char* what) {
  std::fprintf(stderr, "feltwire-server: %s\n", what);
  return status;
}

/// An option that, given on the command line, stands over the file.
using Overrides = std::vector<std::function<void(feltwire::ServerConfig&)>>;

/// Adds an option for a field of the configuration.
template <class Field>
CLI::Option* add(CLI::App& app, Overrides& overrides, feltwire::ServerConfig& given,
                 Field feltwire::ServerConfig::*field, const std::string& name,
                 const std::string& help) {
  CLI::Option* option = app.add_option(name, given.*field, help);
  overrides.push_back([option, field, &given](feltwire::ServerConfig& config) {
    if (!option->empty()) config.*field = given.*field;
  });
  return option;
}

void add_serving(CLI::App& app, Overrides& overrides, feltwire::ServerConfig& given) {
  using Config = feltwire::ServerConfig;
  add(app, overrides, given, &Config::scenes, "--scene", "Scene file (JSON); repeat for several")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  add(app, overrides, given, &Config::port, "--port",
      "Control port (tcp); the scenes have the udp ports after it; 0: a free place for all")
      ->capture_default_str();
  add(app, overrides, given, &Config::address, "--address",
      "IP address to listen on; every network: '::', with IPv4 alone: 0.0.0.0")
      ->capture_default_str();
  add(app, overrides, given, &Config::silence_timeout, "--silence-timeout",
      "[s] a session that sends nothing for so long ends")
      ->capture_default_str();
  add(app, overrides, given, &Config::profile, "--profile",
      "Of the line that the sessions share, " + feltwire::network_profile_names() +
          ": a client that asks for more datagrams gets the profile's");
  add(app, overrides, given, &Config::busy_poll, "--busy-poll",
      "[us] a scene's thread asks for datagrams busily before it sleeps: faster answers for CPU "
      "time; inf: it never sleeps and takes a core")
      ->capture_default_str();
  add(app, overrides, given, &Config::dscp, "--dscp",
      "Mark of the replies for the network: cs0 to cs7, af11 to af43, ef, va or 0 to 63")
      ->capture_default_str();
  add(app, overrides, given, &Config::log_level, "--log-level",
      "trace, debug, info, warning, error or off")
      ->capture_default_str();
}

void add_security(CLI::App& app, Overrides& overrides, feltwire::ServerConfig& given) {
  using Config = feltwire::ServerConfig;
  const auto group = "Who gets in (SECURITY.md)";
  add(app, overrides, given, &Config::state, "--state",
      "Folder of certificate, key and tokens, which are made where they are missing; "
      "$XDG_STATE_HOME/feltwire or ~/.local/state/feltwire when not given")
      ->envname("FELTWIRE_STATE")
      ->group(group);
  add(app, overrides, given, &Config::certificate, "--certificate",
      "FILE (PEM) instead of the state folder's")
      ->group(group);
  add(app, overrides, given, &Config::key, "--key", "FILE (PEM) of the certificate's key")
      ->group(group);
  add(app, overrides, given, &Config::client_ca, "--client-ca",
      "FILE (PEM): clients need a certificate of these authorities, too")
      ->group(group);
  add(app, overrides, given, &Config::tokens, "--tokens",
      "FILE of the tokens instead of the state folder's")
      ->envname("FELTWIRE_TOKENS")
      ->group(group);
  add(app, overrides, given, &Config::max_sessions_per_client, "--max-sessions-per-client",
      "Of all tokens with one client's name")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::join_rate, "--join-rate",
      "[1/s] joins and wrong tokens of one address, for ever")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::join_burst, "--join-burst", "And at once")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::handshake_timeout, "--handshake-timeout",
      "[s] from connecting to a good token")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::idle_timeout, "--idle-timeout",
      "[s] a control connection that asks nothing ends")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::max_connections, "--max-connections", "Control connections")
      ->capture_default_str()
      ->group(group);
  add(app, overrides, given, &Config::max_connections_per_address, "--max-connections-per-address",
      "Of these, from one address")
      ->capture_default_str()
      ->group(group);
}

/// What was given on the command line stands over the file.
feltwire::ServerConfig configuration(int argc, char** argv) {
  CLI::App app("A networked haptic rendering server: hands come in over UDP, forces go back.",
               "feltwire-server");
  app.footer(kExamples);
  feltwire::ServerConfig given;
  std::string file, explained;
  app.add_option("--config", file, "Configuration file (JSON); options given here win over it");
  Overrides overrides;
  add_serving(app, overrides, given);
  add_security(app, overrides, given);
  app.add_option("--explain", explained,
                 "Print what this scene file needs, and which objects need it, and end");
  try {
    app.parse(argc, argv);
  } catch (const CLI::ParseError& error) {
    if (error.get_exit_code() == 0) std::exit(app.exit(error));  // --help
    std::exit(fail(kBadUsage, (std::string(error.what()) + " (see --help)").c_str()));
  }
  if (!explained.empty()) {
    std::fputs(explain(feltwire::load_scene(explained)).c_str(), stdout);
    std::exit(0);
  }
  if (file.empty()) return given;
  feltwire::ServerConfig config = feltwire::load_config(file);
  for (const auto& take : overrides) take(config);
  return config;
}

/// As a shell reads it back.
std::string shell_word(const std::string& word) {
  constexpr const char* kPlain =
      "abcdefghijklmnopqrstuvwxyzABCDEFGHIJKLMNOPQRSTUVWXYZ0123456789_-+=./:,@%";
  if (!word.empty() && word.find_first_not_of(kPlain) == std::string::npos) return word;
  std::string text = "'";
  for (const char c : word) text += c == '\'' ? std::string("'\\''") : std::string(1, c);
  return text + "'";
}

/// The command line that joins from this machine.
std::string join_line(const feltwire::ServerConfig& config, const feltwire::Server& server) {
  const auto address = asio::ip::make_address(config.address);
  const std::string host = address.is_unspecified() ? "127.0.0.1" : config.address;
  const auto token = feltwire::local_token_file(config);
  const bool has_token = !token.empty() && std::filesystem::exists(token);
  return "feltwire-client --connect " +
         (host.find(':') == std::string::npos ? host : "[" + host + "]") + ":" +
         std::to_string(server.control_port()) + " --scene " +
         shell_word(server.scenes().front().scene) + " --fingerprint " +
         feltwire::to_string(server.fingerprint()) + " --token-file " +
         (has_token ? shell_word(std::filesystem::absolute(token).string()) : "FILE");
}

void print_ready(const feltwire::ServerConfig& config, const feltwire::Server& server) {
  std::printf("fingerprint: %s\n", feltwire::to_string(server.fingerprint()).c_str());
  std::printf("listening: control tcp %u", unsigned{server.control_port()});
  for (const auto& scene : server.scenes())
    std::printf(", scene %s udp %u", scene.scene.c_str(), unsigned{scene.udp_port});
  std::printf("\njoin: %s\n", join_line(config, server).c_str());
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
  feltwire::forbid_core_dumps();
  if (argc > 1 && std::string_view(argv[1]) == "token")
    return feltwire::token_command(argc - 1, argv + 1);
  try {
    const feltwire::ServerConfig config = configuration(argc, argv);
    validate(config);
    spdlog::set_default_logger(spdlog::stderr_color_mt("feltwire-server"));
    spdlog::set_level(spdlog::level::from_str(config.log_level));

    // Blocked before any thread starts, so that only this one takes them.
    sigset_t ending;
    sigemptyset(&ending);
    sigaddset(&ending, SIGINT);
    sigaddset(&ending, SIGTERM);
    pthread_sigmask(SIG_BLOCK, &ending, nullptr);

    feltwire::Server server(config);
    print_ready(config, server);
    int signal = 0;
    sigwait(&ending, &signal);
    spdlog::info("{}: saying goodbye", signal == SIGINT ? "interrupted" : "terminated");
    server.stop();
    std::fputs((text(server.summary()) + text(server.control_summary())).c_str(), stdout);
    return 0;
  } catch (const std::invalid_argument& error) {
    return fail(kBadUsage, error.what());
  } catch (const std::exception& error) {
    return fail(kCannotRun, error.what());
  }
}

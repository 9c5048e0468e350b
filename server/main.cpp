// feltwire-server: serves scenes to haptic clients until SIGINT or SIGTERM.

#include <spdlog/sinks/stdout_color_sinks.h>
#include <spdlog/spdlog.h>

#include <CLI/CLI.hpp>
#include <csignal>
#include <cstdio>

#include "core/scene/needs.hpp"
#include "protocol/profiles.hpp"
#include "server/server.hpp"

namespace {

constexpr int kBadUsage = 2, kCannotRun = 1;

constexpr const char* kExamples = R"(
Examples:
  feltwire-server --scene scenes/wall.json
      one scene for clients on this machine: control on tcp 7400, the scene on udp 7401
  feltwire-server --scene a.json --scene b.json --address :: --port 9000
      two scenes for every network this machine is in (nobody is authenticated: trusted networks
      only); open tcp 9000 and udp 9001 and 9002
  feltwire-server --config server.json --log-level debug
      everything from a file, one option from here

Once every port is open one line says so:
  listening: control tcp 7400, scene wall udp 7401
End it with Ctrl-C or SIGTERM: clients are told, and a summary is printed.)";

int fail(int status, const char* what) {
  std::fprintf(stderr, "feltwire-server: %s\n", what);
  return status;
}

/// What was given on the command line stands over the file.
feltwire::ServerConfig configuration(int argc, char** argv) {
  CLI::App app("A networked haptic rendering server: hands come in over UDP, forces go back.",
               "feltwire-server");
  app.footer(kExamples);
  feltwire::ServerConfig given;
  std::string file, explained;
  app.add_option("--config", file, "Configuration file (JSON); options given here win over it");
  const auto* scenes =
      app.add_option("--scene", given.scenes, "Scene file (JSON); repeat for several")
          ->expected(1)
          ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  const auto* port = app.add_option("--port", given.port,
                                    "Control port (tcp); the scenes have the udp ports after it; "
                                    "0: chosen by the system")
                         ->capture_default_str();
  const auto* address =
      app.add_option("--address", given.address,
                     "IP address to listen on; every network: '::', with IPv4 alone: 0.0.0.0")
          ->capture_default_str();
  const auto* silence = app.add_option("--silence-timeout", given.silence_timeout,
                                       "[s] a session that sends nothing for so long ends")
                            ->capture_default_str();
  const auto* profile =
      app.add_option("--profile", given.profile,
                     "Of the line that the sessions share, " + feltwire::network_profile_names() +
                         ": a client that asks for more datagrams gets the profile's");
  const auto* busy =
      app.add_option("--busy-poll", given.busy_poll,
                     "[us] a scene's thread asks for datagrams busily before it sleeps: faster "
                     "answers for CPU time; inf: it never sleeps and takes a core")
          ->capture_default_str();
  const auto* dscp = app.add_option("--dscp", given.dscp,
                                    "Mark of the replies for the network: cs0 to cs7, af11 to "
                                    "af43, ef, va or 0 to 63")
                         ->capture_default_str();
  const auto* level =
      app.add_option("--log-level", given.log_level, "trace, debug, info, warning, error or off")
          ->capture_default_str();
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
  if (!scenes->empty()) config.scenes = given.scenes;
  if (!port->empty()) config.port = given.port;
  if (!address->empty()) config.address = given.address;
  if (!silence->empty()) config.silence_timeout = given.silence_timeout;
  if (!profile->empty()) config.profile = given.profile;
  if (!busy->empty()) config.busy_poll = given.busy_poll;
  if (!dscp->empty()) config.dscp = given.dscp;
  if (!level->empty()) config.log_level = given.log_level;
  return config;
}

void print_ready(const feltwire::Server& server) {
  std::printf("listening: control tcp %u", unsigned{server.control_port()});
  for (const auto& scene : server.scenes())
    std::printf(", scene %s udp %u", scene.scene.c_str(), unsigned{scene.udp_port});
  std::printf("\n");
  std::fflush(stdout);
}

}  // namespace

int main(int argc, char** argv) {
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
    print_ready(server);
    int signal = 0;
    sigwait(&ending, &signal);
    spdlog::info("{}: saying goodbye", signal == SIGINT ? "interrupted" : "terminated");
    server.stop();
    std::fputs(text(server.summary()).c_str(), stdout);
    return 0;
  } catch (const std::invalid_argument& error) {
    return fail(kBadUsage, error.what());
  } catch (const std::exception& error) {
    return fail(kCannotRun, error.what());
  }
}

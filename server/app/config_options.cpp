#include "server/app/config_options.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>

#include "protocol/session/profiles.hpp"
#include "server/app/fleet_settings.hpp"

namespace feltwire {
namespace {

void add_serving(CLI::App& app, ServerConfig& config) {
  app.add_option("--scene", config.scenes,
                 "Scene file (JSON). Repeat the option for several scenes")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option("--port", config.port,
                 "Control port (TCP). The next port (UDP) is for the scenes. 0: free ports")
      ->capture_default_str();
  app.add_option("--address", config.address,
                 "IP address to listen on. '::': every network. 0.0.0.0: every IPv4 network")
      ->capture_default_str();
  app.add_option("--silence-timeout", config.silence_timeout,
                 "[s] The server ends a session that sends nothing for this time")
      ->capture_default_str();
  app.add_option("--max-sessions-per-scene", config.max_sessions_per_scene,
                 "Largest number of sessions in one scene")
      ->capture_default_str();
  app.add_option("--sample-rate-limit", config.sample_rate_limit,
                 "Factor of its servo rate up to which a session may send samples. Twice the limit "
                 "ends the "
                 "session")
      ->capture_default_str();
  app.add_option("--slow-down", config.slow_down,
                 "Sessions that are asked for fewer datagrams while a scene's thread is short of "
                 "time, in this order: observers, hands. off: none")
      ->capture_default_str();
  app.add_option("--profile", config.profile,
                 "Network that the sessions share, " + network_profile_names() +
                     ". The profile limits the datagram rate of each client");
  app.add_option(
         "--busy-poll", config.busy_poll,
         "[us] Time for which a scene's thread polls for datagrams before it sleeps. Longer "
         "polling "
         "gives faster answers and costs CPU time. inf: never sleep. This uses a whole core")
      ->capture_default_str();
  app.add_flag(
      "--real-time", config.real_time,
      "Use real-time scheduling (SCHED_FIFO) for the scenes' threads, and lock the memory. This "
      "gives fewer late answers. Use it on machines that mainly serve scenes");
  app.add_option("--dscp", config.dscp,
                 "DSCP mark of the replies: cs0 to cs7, af11 to af43, ef, va or 0 to 63")
      ->capture_default_str();
  app.add_option(
      "--web", config.web,
      "PORT or ADDRESS:PORT of the live page, which shows the scenes in a browser. PORT alone "
      "serves this machine. ADDRESS:PORT also serves other machines, by HTTPS. 0: a free port. "
      "Default: no page");
  app.add_option(
         "--web-name", config.web_names,
         "Host name that browsers may use for the live page, in addition to IP addresses and "
         "localhost. Repeat the option for several names")
      ->expected(1)
      ->multi_option_policy(CLI::MultiOptionPolicy::TakeAll);
  app.add_option(
      "--record", config.recording.file,
      "FILE.mcap for a recording of all inputs and pictures of the scene. feltwire-lab replay can "
      "read it. With several scenes, each has a FILE-SCENE.mcap");
  app.add_option("--record-max-mib", config.recording.max_mib,
                 "[MiB] Largest size of one recording file. The next files are FILE-0001.mcap, "
                 "FILE-0002.mcap");
  app.add_option("--record-max-seconds", config.recording.max_seconds,
                 "[s] Longest time in one recording file. Then the next file begins");
  app.add_option(
      "--flight-recorder", config.recording.flight_folder,
      "Folder for a recording of the last ten seconds of a scene. The server writes it after a "
      "session that its client did not end, after an overdrawn energy account, and at SIGUSR1");
  app.add_option(
      "--recordings", config.recording.folder,
      "Folder for recordings that admins start and stop on the live page, or with feltwire-client "
      "admin recording. Each ends at --record-max-mib (1024) and --record-max-seconds (3600)");
  app.add_option(
         "--web-hands", config.web_hands,
         "Largest number of hands that viewers of the live page move at the same time, by mouse or "
         "touch. 0: none")
      ->capture_default_str();
  app.add_flag("--demo", config.demo,
               "Keep two simulated hands in each scene, for the live page. They are programs "
               "feltwire-client, which must lie beside this program");
  app.add_option(
      "--metrics", config.metrics,
      "PORT or ADDRESS:PORT of the counters for Prometheus (/metrics), without the live "
      "page. PORT alone serves this machine. ADDRESS:PORT also serves other machines, by "
      "HTTPS and with a token. 0: a free port. Default: none");
  app.add_option("--fleet", config.fleet,
                 "nats://HOST:PORT,HOST:PORT of the directory of a fleet, and settings "
                 "(docs/fleet.md):\n" +
                     fleet_help());
  app.add_option("--log-format", config.log.format, "text, or json: one object a line")
      ->capture_default_str();
  app.add_option("--log-level", config.log.level, "trace, debug, info, warning, error or off")
      ->capture_default_str();
}

void add_security(CLI::App& app, ServerConfig& config) {
  const auto group = "Access (SECURITY.md)";
  app.add_option(
         "--state", config.state,
         "Folder of the certificate, its key and the tokens. The server creates missing files. "
         "Default: $XDG_STATE_HOME/feltwire or ~/.local/state/feltwire")
      ->group(group);
  app.add_option("--certificate", config.certificate,
                 "FILE (PEM) of the server's certificate. Default: from --state")
      ->group(group);
  app.add_option("--key", config.key, "FILE (PEM) of the key of --certificate")->group(group);
  app.add_option(
         "--client-ca", config.client_ca,
         "FILE (PEM) of authorities. Every client then also needs a certificate from one of them")
      ->group(group);
  app.add_option("--tokens", config.tokens, "FILE of the tokens. Default: from --state")
      ->group(group);
  app.add_option("--max-sessions-per-client", config.max_sessions_per_client,
                 "Largest number of simultaneous sessions of one client name, over all its tokens")
      ->capture_default_str()
      ->group(group);
  app.add_option("--join-rate", config.join_rate,
                 "[1/s] Sustained rate limit. It counts joins, parameter changes and reloads of "
                 "each client, "
                 "and wrong tokens from each network (IPv4 /24, IPv6 /64)")
      ->capture_default_str()
      ->group(group);
  app.add_option("--join-burst", config.join_burst,
                 "Largest burst of the requests that --join-rate limits")
      ->capture_default_str()
      ->group(group);
  app.add_option("--handshake-timeout", config.connections.handshake_timeout,
                 "[s] Longest time from a connection to its valid token")
      ->capture_default_str()
      ->group(group);
  app.add_option("--idle-timeout", config.connections.idle_timeout,
                 "[s] The server closes a control connection that sends no request for this time")
      ->capture_default_str()
      ->group(group);
  app.add_option("--max-connections", config.connections.max,
                 "Largest number of control connections. Half of them are reserved for clients "
                 "with a valid "
                 "token")
      ->capture_default_str()
      ->group(group);
  app.add_option(
         "--max-connections-per-network", config.connections.max_per_network,
         "Largest number of connections from one network, in each half of --max-connections")
      ->capture_default_str()
      ->group(group);
  app.add_option(
         "--handshake-rate", config.connections.handshake_rate,
         "[1/s] Sustained rate limit of control connections from one network. Further connections "
         "wait up to 3 s")
      ->capture_default_str()
      ->group(group);
  app.add_option("--handshake-burst", config.connections.handshake_burst,
                 "Largest burst of the connections that --handshake-rate limits")
      ->capture_default_str()
      ->group(group);
}

}  // namespace

void add_config_options(CLI::App& app, ServerConfig& config) {
  add_serving(app, config);
  add_security(app, config);
}

std::string server_file_value(std::string_view option, const std::string& value,
                              const std::filesystem::path& folder) {
  constexpr std::array<std::string_view, 9> kFiles = {"scene",  "state",           "certificate",
                                                      "key",    "client-ca",       "tokens",
                                                      "record", "flight-recorder", "recordings"};
  if (std::ranges::count(kFiles, option) > 0) return (folder / value).string();
  // JSON has no infinity.
  if (option == "busy-poll" && value == "-1") return "inf";
  if (option.starts_with("record-max-") && (value == "0" || value.starts_with('-'))) return "inf";
  return value;
}

}  // namespace feltwire

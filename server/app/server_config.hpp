#pragma once

#include <cmath>
#include <cstdint>
#include <filesystem>
#include <optional>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/net/ports.hpp"
#include "server/access/security_options.hpp"

namespace feltwire {

/// The limits of control connections.
struct ConnectionConfig {
  double handshake_timeout = 5.0;  // [s] from connecting to a valid token
  double idle_timeout = 60.0;      // [s] a connection without a request ends
  int max = 512;                   // half of them for those with a valid token
  int max_per_network = 128;       // of either half; an IPv4 /24, an IPv6 /64
  double handshake_rate = 50.0;    // [1/s] connections of one network, sustained,
  double handshake_burst = 100.0;  // and at once
};

/// The files that the server writes about its scenes.
struct RecordingConfig {
  std::filesystem::path file;           // FILE.mcap for the inputs of a scene; empty: none
  double max_mib = HUGE_VAL;            // of one file of several, or of an admin's recording
  double max_seconds = HUGE_VAL;        // the same
  std::filesystem::path flight_folder;  // of flight records; empty: none
  std::filesystem::path folder;         // of recordings that admins start; empty: none
};

struct LogConfig {
  std::string level = "info";
  std::string format = "text";  // or json
};

/// SecurityOptions::address: other machines on request only.
struct ServerConfig : SecurityOptions {
  std::vector<std::filesystem::path> scenes;  // at least one
  int port = kDefaultPort;       // control (tcp); the scenes' ports (udp) follow it; 0: free ports
  double silence_timeout = 2.0;  // [s]
  int max_sessions_per_scene = 64;
  double sample_rate_limit = 1.5;             // of a session, times its servo rate
  std::string slow_down = "observers,hands";  // slow_down_order()
  int max_sessions_per_client = 16;           // of all tokens with one client's name
  double join_rate = 20.0;                    // [1/s] joins, changes and wrong tokens, sustained,
  double join_burst = 60.0;                   // and at once (server/control/request_limits.hpp)
  ConnectionConfig connections;
  std::string profile;       // line that the sessions share, lan, wan or thin; empty: no limit
  double busy_poll = 0.0;    // [us] before a scene's thread sleeps; 0: at once, infinity: never
  bool real_time = false;    // scenes' threads have priority over all others
  std::string dscp = "cs0";  // of replies: a name or a number, see protocol/net/udp_socket.hpp
  std::string web;           // of the live page: "PORT" or "ADDRESS:PORT"; empty: there is none
  std::string metrics;       // the same for a port with the counters alone; empty: there is none
  std::vector<std::string> web_names;  // host names that browsers may use for the page
  RecordingConfig recording;
  bool demo = false;  // two simulated hands in each scene (server/app/demo_hands.hpp)
  std::string fleet;  // directory and settings (server/app/fleet_settings.hpp); empty: no fleet
  int web_hands = 4;  // sessions of role pointer: hands that viewers of the page hold, at once
  LogConfig log;
};

/// Reads a configuration file, whose members are the options of add_config_options(). Missing
/// values keep their defaults. A wrong file is wrong usage: throws std::invalid_argument
/// "file:line: field: what is wrong".
ServerConfig load_config(const std::filesystem::path& file);

/// Reads it from text; paths are relative to the folder of `file`. Throws FileError.
ServerConfig parse_config(std::string_view json, const std::filesystem::path& file);

/// The port of the live page in examples. No other service uses it, as with kDefaultPort.
inline constexpr std::uint16_t kExamplePagePort = 6760;

/// The port of the counters alone in examples.
inline constexpr std::uint16_t kExampleMetricsPort = 6762;

/// The address of the live page.
struct WebPlace {
  std::string address = "127.0.0.1";
  std::uint16_t port = 0;  // 0: the operating system chooses
};
/// Reads "6760", "0.0.0.0:6760" or "[::]:6760". Throws std::invalid_argument with the error and the
/// remedy.
WebPlace web_place(std::string_view text);

/// The error in the first name of `names` that is no host name or IP address, with the remedy.
/// Empty: all are. With a scheme, a path or a * a name would match no browser's request.
std::optional<std::string> wrong_web_name(const std::vector<std::string>& names);

/// The first value that is wrong: "--option: range and remedy"; empty: there is none.
std::string config_error(const ServerConfig& config);

/// Throws std::invalid_argument with config_error(), or if there is no scene.
void validate(const ServerConfig& config);

}  // namespace feltwire

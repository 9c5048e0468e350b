#pragma once

#include <filesystem>
#include <string>
#include <string_view>
#include <vector>

#include "protocol/net/ports.hpp"
#include "server/access/security_options.hpp"

namespace feltwire {

/// SecurityOptions::address: other machines on request only.
struct ServerConfig : SecurityOptions {
  std::vector<std::filesystem::path> scenes;  // at least one
  int port = kDefaultPort;  // control (tcp), the scenes' (udp) follow one by one; 0: a free place
  double silence_timeout = 2.0;  // [s]
  int max_sessions_per_scene = 64;
  double sample_rate_limit = 1.5;         // of a session, times its servo rate
  int max_sessions_per_client = 16;       // of all tokens with one client's name
  double join_rate = 20.0;                // [1/s] joins, changes and wrong tokens, for ever,
  double join_burst = 60.0;               // and at once (server/control/control_service.hpp)
  double handshake_timeout = 5.0;         // [s] from connecting to a good token
  double idle_timeout = 60.0;             // [s] a connection that asks nothing ends
  int max_connections = 512;              // half of them for those with a good token
  int max_connections_per_network = 128;  // of either half; an IPv4 /24, an IPv6 /64
  double handshake_rate = 50.0;           // [1/s] connections of one network, for ever,
  double handshake_burst = 100.0;         // and at once
  std::string profile;       // of the line that sessions share, lan, wan or thin; empty: no limit
  double busy_poll = 0.0;    // [us] before a scene's thread sleeps; 0: at once, infinity: never
  bool real_time = false;    // scenes' threads are scheduled before all others
  std::string dscp = "cs0";  // of replies: a name or a number, see protocol/net/udp_socket.hpp
  std::string log_level = "info";
};

/// Reads a configuration file (JSON against server_config.fbs); what it leaves out keeps its
/// default. Throws FileError "file:line: field: what is wrong".
ServerConfig load_config(const std::filesystem::path& file);

/// The same from text; scene paths are taken relative to the folder of `file`.
ServerConfig parse_config(std::string_view json, const std::filesystem::path& file);

/// Throws std::invalid_argument naming the option, its range and the remedy.
void validate(const ServerConfig& config);

}  // namespace feltwire

#pragma once
// The value of --fleet: nats://n1:4222,n2:4222,n3:4222,name=host-a,announce=10.0.0.5,keys=DIR

#include <filesystem>
#include <memory>
#include <string>
#include <vector>

#include "server/app/server_config.hpp"
#include "server/fleet/directory.hpp"

namespace feltwire {

struct FleetSettings {
  std::vector<std::string> servers;  // HOST:PORT of the NATS servers; empty: a directory in memory
  std::string name;                  // of this host; default: the machine's
  std::vector<std::string> addresses;  // IP addresses where clients reach it
  std::string rack;                    // hosts with the same name here fail together
  /// Folder of ca.pem, host.pem, host.key, password, ticket.keys and tokens.json.
  std::filesystem::path keys;
  std::string user = "feltwire";  // at the NATS servers
  int replicas = 0;               // of each bucket; 0: as many as there are servers, 5 at most
};

/// Reads --fleet of a configuration. Throws std::invalid_argument that names the setting and the
/// remedy. Precondition: it is not empty.
FleetSettings fleet_settings(const ServerConfig& config);

/// Returns the file of the fleet's tokens (FleetTokens); empty without a fleet. Throws as
/// fleet_settings().
std::filesystem::path fleet_token_file(const ServerConfig& config);

/// Connects to the directory. Throws FileError or std::runtime_error with the remedy.
std::shared_ptr<Directory> open_fleet_directory(const FleetSettings& settings);

/// The settings with their descriptions, for --help-all.
std::string fleet_help();

}  // namespace feltwire

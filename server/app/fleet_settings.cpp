#include "server/app/fleet_settings.hpp"

#include <unistd.h>

#include <CLI/CLI.hpp>
#include <algorithm>
#include <array>
#include <asio/ip/address.hpp>
#include <stdexcept>
#include <string_view>
#include <system_error>

#include "core/base/file_error.hpp"
#include "core/base/regular_file.hpp"
#include "protocol/command_line/settings.hpp"
#include "protocol/crypto/private_file.hpp"
#include "protocol/wire/control.hpp"
#include "server/access/security.hpp"
#include "server/fleet_host/open_directory.hpp"

namespace feltwire {
namespace {

constexpr std::string_view kNats = "nats://", kMemory = "memory";
constexpr int kMostReplicas = 5;

void add_settings(CLI::App& keys, FleetSettings& settings, std::string& addresses) {
  keys.add_option("--name", settings.name,
                  "Name of this host in the fleet. Default: the machine's");
  keys.add_option("--announce", addresses,
                  "IP addresses where clients reach this host. Default: --address");
  keys.add_option("--rack", settings.rack, "Hosts with the same name here fail together");
  keys.add_option("--keys", settings.keys,
                  "Folder of ca.pem, host.pem, host.key and password for the NATS servers. The "
                  "server keeps the keys of its tickets there. Default: fleet in --state");
  keys.add_option("--user", settings.user, "User at the NATS servers")->capture_default_str();
  keys.add_option("--replicas", settings.replicas,
                  "Copies of the directory. Default: as many as there are servers, 5 at most");
}

std::vector<std::string> parts(std::string_view text) {
  std::vector<std::string> result;
  while (!text.empty()) {
    const auto end = std::min(text.find(','), text.size());
    result.emplace_back(text.substr(0, end));
    text.remove_prefix(std::min(end + 1, text.size()));
  }
  return result;
}

std::string machine_name() {
  std::array<char, 256> name{};
  ::gethostname(name.data(), name.size() - 1);
  return name.data();
}

[[noreturn]] void wrong(const std::string& what) {
  throw std::invalid_argument("--fleet: " + what);
}

void check(FleetSettings& settings, const ServerConfig& config) {
  if (settings.name.empty() || settings.name.size() > control::kMaxName)
    wrong("name: must have 1 to 128 bytes");
  if (settings.addresses.empty()) settings.addresses.push_back(config.address);
  for (const std::string& text : settings.addresses) {
    std::error_code no_address;
    const auto address = asio::ip::make_address(text, no_address);
    if (no_address) wrong("announce: '" + text + "' is no IP address");
    if (address.is_unspecified())
      wrong(
          "announce: is missing; give the IP address where clients reach this host, as the server "
          "listens on every network");
  }
  if (settings.replicas < 0 || settings.replicas > kMostReplicas) wrong("replicas: must be 1 to 5");
  if (settings.replicas == 0)
    settings.replicas = std::clamp(static_cast<int>(settings.servers.size()), 1, kMostReplicas);
}

}  // namespace

FleetSettings fleet_settings(const ServerConfig& config) {
  FleetSettings settings;
  settings.name = machine_name();
  std::string addresses;
  CLI::App keys;
  add_settings(keys, settings, addresses);
  SettingsText given = split_settings(config.fleet, keys, SettingsBegin::name, "--fleet");
  read_settings(keys, given.settings, "--fleet");
  settings.addresses = parts(addresses);
  if (given.begin.starts_with(kNats)) {
    settings.servers = parts(std::string_view(given.begin).substr(kNats.size()));
    if (settings.servers.empty()) wrong("has no server; write nats://HOST:PORT");
  } else if (given.begin != kMemory) {
    wrong("'" + given.begin + "' is no directory; write nats://HOST:PORT,HOST:PORT");
  }
  if (settings.keys.empty())
    settings.keys = (config.state.empty() ? default_state_folder() : config.state) / "fleet";
  check(settings, config);
  return settings;
}

std::filesystem::path fleet_token_file(const ServerConfig& config) {
  if (config.fleet.empty()) return {};
  return fleet_settings(config).keys / "tokens.json";
}

std::shared_ptr<Directory> open_fleet_directory(const FleetSettings& settings) {
  if (settings.servers.empty()) return memory_directory();
  NatsOptions options;
  for (const std::string& server : settings.servers) options.servers.push_back("tls://" + server);
  options.authority = settings.keys / "ca.pem";
  options.certificate = settings.keys / "host.pem";
  options.key = settings.keys / "host.key";
  options.user = settings.user;
  const std::filesystem::path password = settings.keys / "password";
  for (const auto& secret : {options.key, password})
    if (const auto open = exposure(secret)) throw FileError(*open);
  constexpr std::size_t kLargest = 4096;  // [bytes]
  std::string text = read_regular_file(password, kLargest, "write the user's password to it");
  options.password = Secret(std::string_view(text).substr(0, text.find_first_of("\r\n")));
  wipe(text);
  options.replicas = settings.replicas;
  options.patience = std::chrono::milliseconds(500);  // a takeover waits for one call at most
  return open_nats_directory(options);
}

std::string fleet_help() {
  FleetSettings settings;
  std::string addresses;
  CLI::App keys;
  add_settings(keys, settings, addresses);
  return settings_help(keys);
}

}  // namespace feltwire

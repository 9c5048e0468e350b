#include "server/app/fleet_command.hpp"

#include <CLI/CLI.hpp>
#include <algorithm>
#include <cstdio>
#include <map>
#include <memory>
#include <stdexcept>
#include <string>
#include <thread>
#include <vector>

#include "core/base/visible_text.hpp"
#include "protocol/net/ports.hpp"
#include "server/app/fleet_settings.hpp"
#include "server/app/fleet_wishes.hpp"
#include "server/app/server_config.hpp"
#include "server/app/subcommand.hpp"
#include "server/fleet_host/known_hosts.hpp"

namespace feltwire {
namespace {

constexpr const char* kFleetExamples = R"(
Example:
  feltwire-server fleet status --fleet nats://n1:4222,n2:4222,n3:4222,keys=/etc/feltwire/fleet
      the hosts and scenes of the fleet; takes three seconds, to see which hosts live
  feltwire-server fleet drain host-a --config /etc/feltwire/server.conf
      host-a hands its scenes over to other hosts and takes no others, until it starts anew
  feltwire-server fleet move room host-b --config /etc/feltwire/server.conf)";

template <class Record>
using Records = std::map<std::string, Record>;

/// Whether the host has announced itself again between the two lists.
bool lives(const Records<HostRecord>& before, const HostRecord& now) {
  const auto found = before.find(now.host.name);
  return found == before.end() || found->second.host != now.host || found->second.beat < now.beat;
}

std::string place_of(const HostRecord& host) {
  if (host.addresses.empty()) return "-";
  return host_and_port(host.addresses.front(), host.control_port);
}

std::string name_of(const HostName& host) {
  return host.number != 0 ? visible(host.name) : std::string("-");
}

void show(Directory& directory) {
  const Records<HostRecord> before = host_records(directory);
  std::this_thread::sleep_for(kBeat + kBeat / 2);
  const Records<HostRecord> hosts = host_records(directory);
  const Records<SceneRecord> scenes = scene_records(directory);
  std::printf("%-20s  %-7s  %-28s  %-6s  %-6s  %s\n", "host", "state", "address", "hands", "scenes",
              "version");
  for (const auto& [name, host] : hosts) {
    const auto served = std::ranges::count_if(
        scenes, [&owner = host.host](const auto& entry) { return entry.second.owner == owner; });
    const char* const state = !lives(before, host) ? "silent" : host.draining ? "drains" : "lives";
    std::printf("%-20s  %-7s  %-28s  %-6u  %-6td  %s\n", visible(name).c_str(), state,
                visible(place_of(host)).c_str(), host.hands, served, visible(host.version).c_str());
  }
  for (const auto& [name, host] : hosts)
    if (!host.kept.empty())
      std::printf("%s drains, and keeps %s\n", visible(name).c_str(), visible(host.kept).c_str());
  std::printf("\n%-20s  %-20s  %-6s  %s\n", "scene", "served by", "term", "standby");
  for (const auto& [name, scene] : scenes) {
    const auto owner = hosts.find(scene.owner.name);
    const bool there = owner != hosts.end() && owner->second.host == scene.owner;
    std::printf("%-20s  %-20s  %-6llu  %s\n", visible(name).c_str(),
                (name_of(scene.owner) + (there ? "" : " (gone)")).c_str(),
                static_cast<unsigned long long>(scene.version.epoch.term),
                name_of(scene.standby).c_str());
  }
}

}  // namespace

int fleet_command(int argc, char** argv) {
  CLI::App app("Shows a fleet of servers, and moves its scenes", "feltwire-server fleet");
  app.footer(kFleetExamples);
  app.require_subcommand(1);
  ServerConfig given;
  std::string config_file;
  std::string host, scene;
  const auto add = [&](const char* name, const char* what) {
    CLI::App* const command = app.add_subcommand(name, what);
    command->add_option("--fleet", given.fleet, "The directory, as the servers' --fleet")
        ->envname("FELTWIRE_SERVER_FLEET");
    command->add_option("--config", config_file, "Configuration file of a server");
    command->add_option("--state", given.state, "State folder of a server")
        ->envname("FELTWIRE_SERVER_STATE");
    return command;
  };
  add("status", "Show the hosts and the scenes");
  CLI::App* const drain =
      add("drain", "Let a host hand its scenes over and take no others, until it starts anew");
  CLI::App* const undrain = add("undrain", "Let a host that drains take scenes again");
  CLI::App* const move = add("move", "Let the host that serves a scene hand it over to another");
  move->add_option("SCENE", scene, "Name of the scene")->required();
  for (CLI::App* const command : {drain, undrain, move})
    command->add_option("HOST", host, "Name of the host, as fleet status shows it")->required();
  return run_subcommand(app, argc, argv, [&] {
    ServerConfig config = config_file.empty() ? given : load_config(config_file);
    if (!given.fleet.empty()) config.fleet = given.fleet;
    if (!given.state.empty()) config.state = given.state;
    if (config.fleet.empty())
      throw std::invalid_argument("no fleet is named; give --fleet nats://HOST:PORT");
    const std::shared_ptr<Directory> directory = open_fleet_directory(fleet_settings(config));
    std::string done;
    if (drain->parsed())
      done = drain_host(*directory, host);
    else if (undrain->parsed())
      done = undrain_host(*directory, host);
    else if (move->parsed())
      done = move_scene(*directory, scene, host);
    else
      return show(*directory);
    std::printf("%s\n", done.c_str());
  });
}

}  // namespace feltwire

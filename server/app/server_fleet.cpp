#include "server/app/server_fleet.hpp"

#include <sodium.h>

#include <algorithm>
#include <chrono>
#include <set>
#include <stdexcept>
#include <system_error>
#include <thread>
#include <utility>

#include "core/base/file_error.hpp"
#include "core/base/private_folder.hpp"
#include "core/build_info/build_info.hpp"
#include "protocol/crypto/private_file.hpp"
#include "protocol/crypto/sha256.hpp"
#include "server/app/fleet_settings.hpp"
#include "server/fleet_host/key_file.hpp"

namespace feltwire {
namespace {

SceneDigest digest_of(const Scene& scene) {
  // The names of files differ from machine to machine, so only their contents count.
  std::set<Sha256> contents;
  if (scene.files() != nullptr)
    for (const auto& [name, bytes] : scene.files()->files) contents.insert(sha256(bytes));
  std::string all;
  for (const Sha256& hash : contents) all.append(hash.begin(), hash.end());
  return sha256(all);
}

/// The share of each core that the hands leave free [%]. A scene has one thread; which core it is
/// on is not known, so the scenes are dealt out in turn.
FleetMember::Load load_of(const SceneHosts& scenes) {
  constexpr double kShareOfAHand = 0.52;  // [%] at 1 kHz, docs/lab/benchmarks.md
  const std::size_t cores = std::max(1U, std::thread::hardware_concurrency());
  std::vector<double> used(cores);
  FleetMember::Load load;
  for (std::size_t i = 0; i < scenes.size(); ++i) {
    load.hands += scenes[i]->sessions();
    used[i % cores] += kShareOfAHand * scenes[i]->sessions();
  }
  constexpr double kWhole = 100.0;
  for (const double share : used)
    load.free_shares.push_back(static_cast<std::uint8_t>(kWhole - std::min(share, kWhole)));
  return load;
}

HostNumber random_number() {
  HostNumber number = 0;
  while (number == 0) randombytes_buf(&number, sizeof number);
  return number;
}

}  // namespace

std::vector<LoadedFleetScene> fleet_scenes(const ServerConfig& config,
                                           const std::vector<Scene>& scenes) {
  std::vector<LoadedFleetScene> loaded;
  if (config.fleet.empty()) return loaded;
  for (const Scene& scene : scenes) loaded.push_back({scene.name(), digest_of(scene)});
  return loaded;
}

ServerFleet::ServerFleet(const ServerConfig& config, Host host) {
  const FleetSettings settings = fleet_settings(config);
  if (const auto failed = make_private_folder(settings.keys))
    throw FileError(settings.keys.string() + ": " + failed.message());
  if (const auto open = open_folder(settings.keys)) throw FileError(*open);
  const std::filesystem::path file = settings.keys / "ticket.keys";
  const std::vector<paseto::SigningKey> keys = ticket_keys(file);
  SigningKeys signing(keys.front());
  if (keys.size() > 1) signing.announce(keys.back());
  HostRecord about;
  about.host = {settings.name, random_number()};
  about.addresses = settings.addresses;
  about.control_port = host.control_port;
  about.fingerprint = host.fingerprint;
  about.version = version();
  about.rack = settings.rack;
  member_ = std::make_unique<FleetMember>(std::move(about), host.loaded, signing);
  AgentCallbacks callbacks{.load = [&scenes = host.scenes] { return load_of(scenes); },
                           .lost = std::move(host.lost),
                           .tokens = std::move(host.tokens)};
  agent_ =
      std::make_unique<HostAgent>(open_fleet_directory(settings), *member_, std::move(callbacks),
                                  AgentFiles{.keys = file, .tokens = fleet_token_file(config)});
}

void ServerFleet::leave() {
  constexpr std::chrono::seconds kHandOver{5}, kRedirect{1};
  const std::size_t before = member_->served().size();
  agent_->drain(kHandOver);
  // Hands that joined before the other host was named know this one only.
  if (member_->served().size() < before) std::this_thread::sleep_for(kRedirect);
}

}  // namespace feltwire

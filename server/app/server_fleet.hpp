#pragma once

#include <cstdint>
#include <functional>
#include <memory>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "server/app/server_config.hpp"
#include "server/control/scene_hosts.hpp"
#include "server/fleet_host/fleet_member.hpp"
#include "server/fleet_host/host_agent.hpp"

namespace feltwire {

/// The scenes with the digests of their files, for a fleet; none without one. A scene whose files
/// are not known has the digest of nothing.
std::vector<LoadedFleetScene> fleet_scenes(const ServerConfig& config,
                                           const std::vector<Scene>& scenes);

/// The part of a server that makes it a host of a fleet (--fleet).
class ServerFleet {
 public:
  struct Host {
    std::uint16_t control_port = 0;
    Fingerprint fingerprint{};
    const SceneHosts& scenes;  // outlives this
    std::vector<LoadedFleetScene> loaded;
    /// Called on the agent's thread: other hosts serve these scenes now.
    std::function<void(std::vector<std::string> scenes)> lost;
    /// Called on the agent's thread: the file of the fleet's tokens has changed.
    std::function<void()> tokens;
  };

  /// Reads the keys and connects to the directory. Throws FileError, std::invalid_argument or
  /// std::runtime_error, each with one clear line. Precondition: `config` has a fleet.
  ServerFleet(const ServerConfig& config, Host host);

  FleetMember& member() { return *member_; }
  /// From now on the host is in the fleet.
  void start() { agent_->start(); }
  /// Hands the scenes over to hosts that take them, and redirects their hands for a moment. Blocks
  /// for some seconds at most. Between start() and stop().
  void leave();
  void stop() { agent_->stop(); }

 private:
  std::unique_ptr<FleetMember> member_;
  std::unique_ptr<HostAgent> agent_;
};

}  // namespace feltwire

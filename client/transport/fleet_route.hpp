#pragma once

#include <chrono>
#include <exception>
#include <vector>

#include "client/transport/control_client.hpp"
#include "protocol/fleet/epoch.hpp"

namespace feltwire {

/// The way to the host that serves a scene: the hosts to ask, and the highest epoch of the scene
/// that the client has seen. Without a fleet it is the given server alone. One object is for one
/// scene.
class FleetRoute {
 public:
  /// Most redirects that one join follows.
  static constexpr int kMostRedirects = 3;

  FleetRoute(ServerAccess first);  // NOLINT(google-explicit-constructor): a server is a route

  /// Joins: asks the hosts one after the other, the host of the session before first, until one
  /// takes the session. Follows redirects. Blocks, and throws as feltwire::join() does:
  /// LastingError if every host refused for good.
  Joined join(const control::JoinRequest& request, std::chrono::milliseconds timeout,
              const GrantLimits& limits = {});

  /// Remembers a session that another route has joined.
  void take(const Joined& joined);

  /// The host of the newest session; before the first one, the given server.
  const ServerAccess& host() const { return host_; }
  const Epoch& highest() const { return highest_; }

 private:
  Joined follow(const ServerAccess& from, control::JoinRequest request,
                std::chrono::milliseconds timeout, const GrantLimits& limits);

  ServerAccess first_, host_;
  std::vector<ServerAccess> hosts_;  // to ask, in this order; never empty
  std::vector<Endpoint> silent_;     // hosts that have not answered during this join()
  Epoch highest_;
};

}  // namespace feltwire

#pragma once
// The scenes of a server, in their order.

#include <algorithm>
#include <cstddef>
#include <cstdint>
#include <memory>
#include <string_view>
#include <vector>

#include "server/scene/scene_host.hpp"

namespace feltwire {

using SceneHosts = std::vector<std::unique_ptr<SceneHost>>;

/// The place of the scene of that name; hosts.size(): there is none.
inline std::size_t index_of_scene(const SceneHosts& hosts, std::string_view name) {
  const auto found =
      std::ranges::find_if(hosts, [&](const auto& host) { return host->name() == name; });
  return static_cast<std::size_t>(found - hosts.begin());
}

/// Returns the place of a scene's UDP port behind the control port. The first scene is next to it.
inline std::uint16_t port_offset(const SceneHosts& hosts, std::size_t scene) {
  return static_cast<std::uint16_t>(1 + hosts[scene]->port() - hosts.front()->port());
}

/// For a name that no scene of the server has.
inline control::Refused unknown_scene(std::string_view name) {
  return {
      control::RefusalCode::unknown_scene,
      "there is no scene '" + std::string(name) + "' here; list the scenes to see which there are"};
}

}  // namespace feltwire

#pragma once
// The scenes of a server, in the order of their UDP ports.

#include <algorithm>
#include <cstddef>
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

/// For a name that no scene of the server has.
inline control::Refused unknown_scene(std::string_view name) {
  return {
      control::RefusalCode::unknown_scene,
      "there is no scene '" + std::string(name) + "' here; list the scenes to see which there are"};
}

}  // namespace feltwire

#pragma once
// The names of a server's scenes, for programs that run beside it.

#include <optional>
#include <string>
#include <vector>

#include "server/app/server_config.hpp"

namespace feltwire {

/// Notes the names in the state folder, if the server has one. A failure is no error: only a
/// warning of `token add` needs them.
void note_scenes(const ServerConfig& config, const std::vector<std::string>& names) noexcept;

/// The names of the scene files of a configuration, else those that the server noted at its newest
/// start. Empty: none is known.
std::vector<std::string> known_scenes(const ServerConfig& config);

/// The warning about a scene of a token that this server does not have, with the nearest name.
/// Empty: it has the scene, the token is for any scene, or no scene of it is known.
std::optional<std::string> unknown_scene(const std::string& scene,
                                         const std::vector<std::string>& known);

}  // namespace feltwire

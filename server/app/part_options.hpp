#pragma once
// The options of the server's parts, from its configuration.

#include "server/app/server_config.hpp"
#include "server/control/control_endpoint.hpp"
#include "server/control/request_limits.hpp"
#include "server/recording/recorder.hpp"
#include "server/scene/scene_host.hpp"
#include "server/scene/scene_loader.hpp"

namespace feltwire {

// Precondition of all: the configuration is valid.

/// For the control endpoint, without its port.
ControlOptions control_options(const ServerConfig& config);

/// For the requests that the control service answers.
ServiceLimits service_limits(const ServerConfig& config);

/// For each scene's host, without its socket.
SceneHostOptions host_options(const ServerConfig& config);

/// The function that loads scenes. For a recording or a fleet, it also keeps the scenes' files in
/// memory.
SceneLoader::Load loader_of(const ServerConfig& config);

/// Warns if scenes' threads that never sleep (--busy-poll inf) leave no core for other threads.
void warn_of_spinning(Nanoseconds busy_poll, std::size_t scenes);

/// For the files about the scenes.
RecorderOptions recorder_options(const ServerConfig& config);

}  // namespace feltwire

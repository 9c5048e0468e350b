#pragma once
// The options of the server's parts, from its configuration.

#include "server/app/server_config.hpp"
#include "server/control/control_endpoint.hpp"
#include "server/control/request_limits.hpp"
#include "server/recording/recorder.hpp"
#include "server/scene/scene_host.hpp"

namespace feltwire {

// Precondition of all: the configuration is valid.

/// For the control endpoint, without its port.
ControlOptions control_options(const ServerConfig& config);

/// For the requests that the control service answers.
ServiceLimits service_limits(const ServerConfig& config);

/// For each scene's host, without its socket.
SceneHostOptions host_options(const ServerConfig& config);

/// For the files about the scenes.
RecorderOptions recorder_options(const ServerConfig& config);

}  // namespace feltwire

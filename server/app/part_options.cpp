#include "server/app/part_options.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <asio/ip/address.hpp>
#include <chrono>
#include <cmath>
#include <thread>

#include "protocol/net/busy_poll.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/net/udp_socket.hpp"
#include "protocol/session/profiles.hpp"
#include "server/web/foxglove_scene.hpp"
#include "server/web/page_messages.hpp"

namespace feltwire {

ControlOptions control_options(const ServerConfig& config) {
  const auto milliseconds = [](double seconds) {
    return std::chrono::duration_cast<std::chrono::milliseconds>(from_seconds(seconds));
  };
  ControlOptions options;
  options.address = asio::ip::make_address(config.address);
  options.handshake_timeout = milliseconds(config.connections.handshake_timeout);
  options.idle_timeout = milliseconds(config.connections.idle_timeout);
  options.max_connections = static_cast<std::size_t>(config.connections.max);
  options.max_connections_per_network =
      static_cast<std::size_t>(config.connections.max_per_network);
  options.max_connections_per_client =
      std::max(options.max_connections_per_client,
               2 * static_cast<std::size_t>(config.max_sessions_per_client));
  options.handshake_rate = config.connections.handshake_rate;
  options.handshake_burst = config.connections.handshake_burst;
  return options;
}

ServiceLimits service_limits(const ServerConfig& config) {
  return {static_cast<std::size_t>(config.max_sessions_per_client),
          static_cast<std::size_t>(config.web_hands), config.join_rate, config.join_burst};
}

SceneHostOptions host_options(const ServerConfig& config) {
  SceneHostOptions options;
  options.address = asio::ip::make_address(config.address);
  options.silence_timeout = from_seconds(config.silence_timeout);
  if (!config.profile.empty()) options.line = &network_profile(config.profile);
  options.dscp = dscp(config.dscp);
  options.max_sessions = static_cast<std::size_t>(config.max_sessions_per_scene);
  options.limits.sample_rate = config.sample_rate_limit;
  options.limits.slow_down = slow_down_order(config.slow_down);
  options.busy_poll = busy_poll_time(config.busy_poll);
  options.real_time = config.real_time;
  return options;
}

SceneLoader::Load loader_of(const ServerConfig& config) {
  const bool keeps = !config.recording.file.empty() || !config.fleet.empty();
  return keeps ? load_scene_keep_and_warn : load_scene_and_warn;
}

void warn_of_spinning(Nanoseconds busy_poll, std::size_t scenes) {
  const unsigned cores = std::thread::hardware_concurrency();
  if (busy_poll == kForever && scenes + 1 > cores)
    spdlog::warn(
        "{} scenes that never sleep (--busy-poll inf) leave no core of {} to anything else; "
        "a bounded busy poll does",
        scenes, cores);
}

namespace {

/// Describes a scene as the live page shows it, and records it itself.
SceneToShow scene_to_show(const Scene& scene) {
  constexpr std::uint32_t kVersion = 1;  // in a file there is no other
  web::FoxgloveScene shown(clock_offset());
  shown.set(scene, kVersion, monotonic_now());
  return {.message = web::scene_text(scene, kVersion),
          .geometry = std::string(shown.topic(web::FoxgloveChannel::geometry).payload.text())};
}

}  // namespace

RecorderOptions recorder_options(const ServerConfig& config) {
  AskedRecordingOptions asked;
  asked.folder = config.recording.folder;
  if (std::isfinite(config.recording.max_mib)) asked.limits.mebibytes = config.recording.max_mib;
  if (std::isfinite(config.recording.max_seconds))
    asked.limits.seconds = config.recording.max_seconds;
  return {.file = config.recording.file,
          .limits = {config.recording.max_mib, config.recording.max_seconds},
          .flight_folder = config.recording.flight_folder,
          .asked = asked,
          .describe = scene_to_show};
}

}  // namespace feltwire

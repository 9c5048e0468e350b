#pragma once
// The log lines about a scene while it runs.

#include <array>
#include <exception>
#include <string>

#include "server/scene/load_log.hpp"
#include "server/scene/log_limit.hpp"
#include "server/scene/scene_sessions.hpp"
#include "server/scene/world_log.hpp"

namespace feltwire {

/// Writes each line with the scene's name. Owns what was told before, and the limits on lines. Only
/// the scene's thread calls it.
class HostLog {
 public:
  explicit HostLog(std::string scene) : scene_(std::move(scene)) {}

  /// Changes since the last call: the states between robots and their hands, the answers of clients
  /// to changes, and the paths that are too short. Allocates only if there are any.
  void tell_of_sessions(SceneSessions& sessions);
  /// Precondition: sessions.world() != nullptr.
  void tell_of_world(const SceneSessions& sessions, Nanoseconds now);
  void tell_of_load(SceneSessions& sessions, Nanoseconds now);
  /// The server failed in this scene. At most one line a second.
  void tell_of_failure(const std::exception& failure, Nanoseconds now);
  /// The scene has another world from now on.
  void begin_anew() noexcept { world_log_.begin_anew(); }

 private:
  void tell_of_links(const SceneSessions& sessions);

  std::string scene_;
  std::array<LinkState, kMostSeats> told_links_{};
  LogLimit failures_;
  WorldLog world_log_;
  LoadLog load_log_;
};

}  // namespace feltwire

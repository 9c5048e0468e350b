#pragma once
// The longest replies that the paths to clients take.

#include <cstddef>
#include <string>
#include <vector>

#include "server/scene/scene_log.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

/// Keeps the limit of each session (SessionSlot::path). After a minute longer replies are tried
/// again.
class PathLimits {
 public:
  /// `log` must outlive this.
  explicit PathLimits(SceneLog& log) : log_(log) {}

  /// The payload of a session's replies is at most so long from now on [bytes]. Never allocates.
  void limit(SessionSlot& slot, std::size_t payload, Nanoseconds now) noexcept;
  /// [bytes] of the payload of a session's reply now; kMaxPayload: its path has no limit. Never
  /// allocates.
  std::size_t room(SessionSlot& slot, Nanoseconds now) noexcept;

  /// The sessions whose path was found to be short since the last call, one log line each.
  /// Allocates if there are any.
  std::vector<std::string> short_paths(const SessionSlots& slots);
  bool has_short_paths() const noexcept { return has_short_paths_; }

 private:
  SceneLog& log_;
  bool has_short_paths_ = false;
};

}  // namespace feltwire

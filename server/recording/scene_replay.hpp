#pragma once
// Computes a scene's recorded session again and compares all replies. No socket, no clock.

#include <cstdint>
#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>
#include <vector>

#include "core/scene/scene.hpp"
#include "server/scene/event_log.hpp"

namespace feltwire {

/// The first difference between a replay and its recording.
struct ReplayDifference {
  std::uint64_t event = 0;   // its number in the recording
  double time = 0.0;         // [s] since the first event
  std::uint32_t hand = 0;    // the session's number; 0: no session
  std::uint64_t sample = 0;  // the newest one of the datagram; 0: none
  std::string what;          // for people
};

struct Replay {
  std::string scene;
  std::string recorded_by, replayed_by;  // version and build
  double time = 0.0;                     // [s] from the first event to the last
  std::uint64_t events = 0, replies = 0, sessions = 0, ticks = 0;
  std::uint64_t lost = 0;                 // events that are missing in the recording
  std::optional<std::uint64_t> cut_at{};  // [bytes] where the last file ends before its end
  std::optional<ReplayDifference> difference{};
  /// Whether all recorded events were computed again, to the same bits.
  bool bit_equal() const { return !difference && lost == 0 && events > 0; }
};

/// Called with an event, its log time [ns since 1970] and the payload of the reply to it, which is
/// bit-equal to the recorded one.
using OnReply = std::function<void(const SceneEvent&, std::uint64_t log_time, Bytes reply)>;

/// Reads the files of one scene's recording, in their order from the first. The scene comes from
/// the first file unless one is given. After the first difference, or where events are missing, it
/// computes no more. Throws FileError that names the file, the place and the remedy.
Replay replay(const std::vector<std::filesystem::path>& files,
              std::shared_ptr<const Scene> given = nullptr, OnReply on_reply = {});

}  // namespace feltwire

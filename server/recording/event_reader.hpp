#pragma once
// The events of a server's recording or flight record, from the messages of its file.

#include <string>
#include <string_view>
#include <vector>

#include "core/recording/mcap_reader.hpp"
#include "server/scene/event_log.hpp"

namespace feltwire {

/// The remedy for a file that has no events, or impossible ones.
inline constexpr const char* kEventRemedy = "give what feltwire-server --record wrote";

class EventReader {
 public:
  /// Whether the message is an event.
  static bool is_event(const mcap::Reader& mcap, const mcap::Message& message);
  /// The payload of the event is valid until the next call. Throws FileError that names the file
  /// and the remedy if an event's numbers are impossible.
  SceneEvent read(const mcap::Message& message, const std::string& file);

 private:
  std::vector<std::uint64_t> payload_;  // aligned, as FlatBuffers reads it
};

}  // namespace feltwire

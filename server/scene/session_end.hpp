#pragma once

#include <cstdint>
#include <string_view>

namespace feltwire {

/// The cause of a session's end, for the log. Recordings contain the number, so add a new one at
/// the end.
enum class SessionEnd : std::uint8_t {
  goodbye,
  asked,
  silent,
  flooded,
  forged,
  disturbing,
  evicted,
  tool_gone,
  failed,
  shut_down
};
struct EndedSession {
  std::uint64_t id = 0;
  SessionEnd how = SessionEnd::goodbye;
  friend bool operator==(const EndedSession&, const EndedSession&) = default;
};
/// The cause in words, for the text after a colon.
std::string_view text(SessionEnd how);

}  // namespace feltwire

#pragma once

#include <cstdint>
#include <string_view>

namespace feltwire {

/// How a session ended, for the log. Recordings have the number: a new one comes last.
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
/// The reason in words, to stand after a colon.
std::string_view text(SessionEnd how);

}  // namespace feltwire

#pragma once
// Changes that a session's client makes itself: the bounding law at the client, its emulated link.

#include <optional>
#include <string>
#include <vector>

#include "protocol/session/client_change.hpp"
#include "protocol/wire/datagram.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

/// The next change for the client of a session. If the client has not answered the previous change,
/// it includes each part of that change that the new change does not replace. Allocates.
AskedChange next_change(const SessionSlot& slot, const ClientChange& change);

/// The answers of clients to the changes that they were asked for (SessionSlot::asked).
class ClientChanges {
 public:
  /// Takes the client's answer, if this report has one. Precondition: the session waits for its
  /// client. Never allocates.
  void hear(SessionSlot& slot, const std::optional<HandReport>& report) noexcept;

  /// The answers since the last call, one log line each. Allocates if there are any.
  std::vector<std::string> answers(const SessionSlots& slots);
  bool has_answers() const noexcept { return has_answers_; }

 private:
  bool has_answers_ = false;
};

}  // namespace feltwire

#pragma once
// A change that an admin wants (protocol/session/client_change.hpp). Another thread checks and
// prepares it, so that the servo's thread allocates no memory for it.

#include <cstdint>
#include <optional>

#include "client/servo/servo.hpp"
#include "protocol/session/client_change.hpp"

namespace feltwire {

/// A received change. `session` counts the sessions after the loop's first: each numbers its
/// changes from 1.
struct WantedChange {
  ClientChange change;
  std::uint32_t session = 0;
};

struct PreparedChange {
  std::uint8_t number = 0;          // the server's number
  std::uint32_t session = 0;        // WantedChange::session
  bool refused = false;             // true: nothing changes, and the server is told
  std::optional<ServoLaw> law;      // receives the previous law
  std::optional<LinkQuality> link;  // for an emulated link
  double taken = -1.0;              // [s] since the first tick; written by the servo's thread
};

}  // namespace feltwire

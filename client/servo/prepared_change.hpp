#pragma once
// A change that an admin wants (protocol/session/client_change.hpp), judged and made ready by
// another thread, so that the servo's takes no memory for it.

#include <cstdint>
#include <optional>

#include "client/servo/servo.hpp"
#include "protocol/session/client_change.hpp"

namespace feltwire {

/// A change as it came. `session` counts those that the loop was given beside its first: each
/// numbers its changes from 1.
struct WantedChange {
  ClientChange change;
  std::uint32_t session = 0;
};

struct PreparedChange {
  std::uint8_t number = 0;          // the server's
  std::uint32_t session = 0;        // WantedChange::session
  bool refused = false;             // then nothing is changed; the server is told
  std::optional<ServoLaw> law;      // gets the law before
  std::optional<LinkQuality> link;  // of an emulated link
  double taken = -1.0;              // [s] since the first tick; written by the servo's thread
};

}  // namespace feltwire

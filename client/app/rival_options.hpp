#pragma once
// Which options of feltwire-client drop others from the environment.

#include "protocol/command_line/environment.hpp"

namespace feltwire {

/// A limit that protects the hand is never dropped: beside an option that excludes it, the client
/// refuses to start.
Rivals client_rivals();

}  // namespace feltwire

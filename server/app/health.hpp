#pragma once

#include <chrono>
#include <string>

namespace feltwire {

/// Asks the server on this machine with these options whether it is running, without a token and
/// without an entry in its counts of refusals. Throws std::runtime_error if no feltwire server
/// answers in time.
void check_health(const std::string& address, int port, std::chrono::milliseconds timeout);

}  // namespace feltwire

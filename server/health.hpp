#pragma once

#include <chrono>
#include <string>

namespace feltwire {

/// Asks the server that runs on this machine with these options for its scenes, as a health check
/// does. Throws std::runtime_error when no feltwire server answers in time; a refusal is an answer.
void check_health(const std::string& address, int port, std::chrono::milliseconds timeout);

}  // namespace feltwire

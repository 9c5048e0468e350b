#pragma once

#include <chrono>
#include <string>

namespace feltwire {

/// Asks the server that runs on this machine with these options whether it is there, without a
/// token and without leaving a trace in its counts of refusals. Throws std::runtime_error when no
/// feltwire server answers in time.
void check_health(const std::string& address, int port, std::chrono::milliseconds timeout);

}  // namespace feltwire

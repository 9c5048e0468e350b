#pragma once
// A server's start, which may take long: its scenes are loaded.

#include <csignal>
#include <optional>

#include "server/app/server.hpp"

namespace feltwire {

/// Starts a server in a thread of its own, so that SIGINT and SIGTERM, blocked in every thread, end
/// the start at once. Logs how far it is every 5 s. Nothing where one of them came; `signal` is
/// then which, and the process should end with std::_Exit where `left_behind` is true: a thread
/// still reads from a file that does not answer. Throws what the server's constructor does.
struct StartEnded {
  int signal = 0;
  bool left_behind = false;
};
std::optional<Server> start_server(const ServerConfig& config, StartEnded& ended,
                                   const web::MakePageHands& hands = {});

}  // namespace feltwire

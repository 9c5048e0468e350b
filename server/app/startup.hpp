#pragma once
// The start of a server, which may take long because it loads the scenes.

#include <csignal>
#include <optional>

#include "server/app/server.hpp"

namespace feltwire {

/// Starts a server in a thread of its own, so that SIGINT and SIGTERM, blocked in every thread, end
/// the start at once. Logs the progress every 5 s. Empty if one of the signals came. Then `signal`
/// is that signal, and the process should end with std::_Exit if `left_behind` is true: a thread
/// still reads from a file that does not answer. Throws the errors of the server's constructor.
struct StartEnded {
  int signal = 0;
  bool left_behind = false;
};
std::optional<Server> start_server(const ServerConfig& config, StartEnded& ended,
                                   const web::MakePageHands& hands = {});

}  // namespace feltwire

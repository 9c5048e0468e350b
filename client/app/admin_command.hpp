#pragma once

#include <string>
#include <vector>

#include "client/transport/control_client.hpp"

namespace feltwire {

/// `feltwire-client admin ...`: shows and changes a running server. The words begin with `admin`.
/// Returns the exit status: 0; 1 if the server refused or is not there; 2 for a wrong command line.
/// Errors are one line on stderr.
int admin_command(int argc, char** argv);

/// Runs such a command for a program: words without `admin`, the server and the credentials, as
/// {"evict", "3"}. Returns the answer as JSON, as with --json. Reads no environment and prints
/// nothing. Throws std::invalid_argument for wrong words, LastingError if the server or a client
/// refuses, and SessionError if the server is not there or a client has not answered yet.
std::string admin_answer(const ServerAccess& server, const std::vector<std::string>& words);

}  // namespace feltwire

#pragma once
// What feltwire-server is told on its command line, by its environment and in its file.

#include <string>

#include "server/config.hpp"

namespace feltwire {

/// What this run is to do.
struct ServerTask {
  ServerConfig config;
  std::string summary;  // file for the counters; empty: none
  std::string explain;  // scene file to say the needs of, and no more; empty: none
  bool health = false;  // ask the server that runs, and no more
};

/// What was given on the command line stands over the environment, and both over the file. Ends the
/// program after --help. Throws std::invalid_argument, one line, and FileError.
ServerTask server_task(int argc, char** argv);

}  // namespace feltwire

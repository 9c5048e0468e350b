#pragma once
// The options of feltwire-server: command line, environment and configuration file.

#include <string>

#include "server/app/server_config.hpp"

namespace feltwire {

/// The task of this run.
struct ServerTask {
  ServerConfig config;
  std::string summary;  // file for the counters; empty: none
  std::string explain;  // scene file whose costs are listed; then the program ends; empty: none
  bool health = false;  // only check the running server
  bool check = false;   // only check the configuration and the files that it names
};

/// The command line wins over the environment, and both win over the file. Ends the
/// program after --help. Throws std::invalid_argument, one line, and FileError.
ServerTask server_task(int argc, char** argv);

}  // namespace feltwire

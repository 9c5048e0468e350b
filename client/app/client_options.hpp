#pragma once
// The command line of feltwire-client.

#include <optional>
#include <string>
#include <variant>
#include <vector>

#include "client/device/mapped_device.hpp"
#include "client/drivers/drivers.hpp"
#include "client/emulated_link/link_options.hpp"
#include "client/run/run_client.hpp"

namespace feltwire {

struct ClientOptions : RunOptions {
  bool list = false;                      // only list the scenes
  bool check = false;                     // test machine and network, and end
  const Driver* driver = nullptr;         // for --device
  DeviceRequest device;                   // the request to that driver
  WorkspaceMapping mapping;               // of its workspace into the scene
  ProtectionOptions protection;           // of the hand at it
  int dscp = 0;                           // of the datagrams
  std::optional<TwoWayLinkOptions> link;  // emulated, between this client and its socket
};

/// Reads the command line. If there is nothing to run (--help, or an error, which has been printed
/// as one line) it returns the exit code instead.
std::variant<ClientOptions, int> parse_options(int argc, char** argv);
/// Reads the words of a command line without the program's name. It reads no environment, and
/// prints nothing. `has_server`: false: the scene is in this process, and the words name no server.
/// Throws std::invalid_argument with one line.
ClientOptions options_of(const std::vector<std::string>& words, bool has_server = true);

}  // namespace feltwire

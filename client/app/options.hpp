#pragma once
// The command line of feltwire-client.

#include <filesystem>
#include <optional>
#include <variant>

#include "client/devices/simulated_device.hpp"
#include "client/emulated_link/link_options.hpp"
#include "client/run/run_client.hpp"

namespace feltwire {

struct ReplayFile {
  std::filesystem::path path;
};

struct ClientOptions : RunOptions {
  bool list = false;                                // list the scenes, nothing else
  bool check = false;                               // judge machine and network, and end
  std::variant<HandTask, ReplayFile> device;        // simulated hand, or a recording
  bool center_given = false, normal_given = false;  // else they are the scene's to say
  DeviceSpec spec;
  int dscp = 0;                           // of the datagrams
  std::optional<TwoWayLinkOptions> link;  // emulated, between this client and its socket
};

/// Reads the command line. When there is nothing to run (--help, or an error, which has been
/// printed as one line) the exit code is returned instead.
std::variant<ClientOptions, int> parse_options(int argc, char** argv);

}  // namespace feltwire

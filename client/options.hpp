#pragma once
// The command line of feltwire-client.

#include <filesystem>
#include <optional>
#include <string>
#include <variant>

#include "client/control_client.hpp"
#include "client/emulated_link/link_options.hpp"
#include "client/servo.hpp"
#include "sim/simulated_device.hpp"

namespace feltwire {

struct ReplayFile {
  std::filesystem::path path;
};

struct ClientOptions {
  ServerAccess server;
  bool list = false;  // list the scenes, nothing else
  std::string name = "feltwire-client";
  std::string scene;
  std::string tool;                                 // that the hand holds; empty: the scene's first
  Role role = Role::operator_;                      // or observer
  std::string device_kind;                          // as given
  std::variant<HandTask, ReplayFile> device;        // simulated hand, or a recording
  bool center_given = false, normal_given = false;  // else they are the scene's to say
  DeviceSpec spec;
  SessionParameters parameters;
  ServoOptions servo;
  double duration = 0.0;   // [s] 0: until stopped
  double busy_poll = 0.0;  // [us] for replies and deadlines, infinity: for ever
  double patience = 30.0;  // [s] to find a lost session again, 0: not at all
  std::optional<std::filesystem::path> report, record, view;
  int dscp = 0;                           // of the datagrams
  std::optional<TwoWayLinkOptions> link;  // emulated, between this client and its socket
};

/// Reads the command line. When there is nothing to run (--help, or an error, which has been
/// printed as one line) the exit code is returned instead.
std::variant<ClientOptions, int> parse_options(int argc, char** argv);

}  // namespace feltwire

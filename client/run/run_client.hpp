#pragma once
// A device in a scene of a server, from joining to the report: what the program of a device maker
// calls.

#include <filesystem>
#include <functional>
#include <memory>
#include <optional>
#include <string>

#include "client/devices/device.hpp"
#include "client/servo/servo.hpp"
#include "client/transport/control_client.hpp"
#include "client/transport/datagram_port.hpp"

namespace feltwire {

inline constexpr std::chrono::milliseconds kControlTimeout{3000};  // of a request to the server

/// One run. The options of feltwire-client fill it, which docs/devices.md explains.
struct RunOptions {
  ServerAccess server;
  std::string name = "feltwire-client";  // of this client, for the server's log and the report
  std::string scene;
  std::string tool;             // that the hand holds; empty: the scene's first
  Role role = Role::operator_;  // or observer
  std::string device_kind;      // for the report
  SessionParameters parameters;
  ServoOptions servo;
  double duration = 0.0;   // [s] 0: until stopped
  double busy_poll = 0.0;  // [us] for replies and deadlines, infinity: for ever
  double patience = 30.0;  // [s] to find a lost session again, 0: not at all
  std::optional<std::filesystem::path> report, record, view;
  /// How datagrams travel to the scene; empty: open_udp_port(). May throw SessionError.
  std::function<std::unique_ptr<DatagramPort>(const Address& scene)> open_port = {};
};

/// Joins, runs the servo loop in a thread of its own until the duration is over, a signal comes
/// (SIGINT, SIGTERM, SIGQUIT, SIGHUP), the device has ended or the session is lost for good; lets
/// the hand go, tells the server, writes the report. Status lines go to stderr, the last line to
/// stdout. Returns the exit code of a program: 0, or 1 when the server ended the session or
/// something failed. From the call on SIGPIPE and SIGXFSZ are ignored and the process makes no core
/// dump, which would hold keys. `device`: not null. Throws SessionError, std::runtime_error (a file
/// that cannot be written) or std::system_error before the device was given any force; never
/// afterwards. Where a thread is left that cannot be waited for, it ends the program with the exit
/// code.
int run_client(std::unique_ptr<Device> device, const RunOptions& options);

}  // namespace feltwire

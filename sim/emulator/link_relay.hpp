#pragma once
// The emulated link as a program between clients and a server: clients join the relay like the
// server.

#include <cstdint>
#include <memory>
#include <string>

#include "client/emulated_link/link_options.hpp"
#include "client/transport/control_client.hpp"

namespace feltwire {

struct LinkRelayOptions {
  std::string address = "127.0.0.1";  // to listen on
  std::uint16_t port = 0;   // control (tcp); the scenes' ports (udp) follow it; 0: free ports
  Endpoint server;          // its control port
  std::size_t scenes = 16;  // number of scene ports, also if the server has fewer
  TwoWayLinkOptions link = {};
};

/// Control connections pass undelayed and unread, each to a connection of its own. Port + i of the
/// relay stands for port + i of the server, as clients count from the control port. Each client
/// (sender of datagrams to such a port) has a socket of its own to the server and a link of its
/// own, the k-th with the random numbers of client k = 0, 1, ...: the first meets what
/// `feltwire-client
/// --link` with the same options would.
class LinkRelay {
 public:
  /// Finds the server's address and listens. The server need not run yet. Throws
  /// std::runtime_error, one line.
  explicit LinkRelay(const LinkRelayOptions& options);
  ~LinkRelay();
  LinkRelay(const LinkRelay&) = delete;
  LinkRelay& operator=(const LinkRelay&) = delete;

  std::uint16_t control_port() const;

  /// Relays in the calling thread until stop() is called.
  void run();
  /// From any thread.
  void stop();

  /// The parameters, and each client with its counters, as JSON (docs/link.md). Do not call it
  /// while run() runs.
  std::string report() const;

 private:
  struct Parts;
  std::unique_ptr<Parts> parts_;
};

}  // namespace feltwire

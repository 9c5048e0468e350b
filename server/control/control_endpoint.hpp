#pragma once
// The control endpoint: TLS 1.3 over TCP, frames of protocol/wire/control.hpp, one thread.

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <map>
#include <memory>
#include <optional>

#include "protocol/wire/control.hpp"
#include "server/access/connection_slots.hpp"
#include "server/access/identity.hpp"
#include "server/control/waiting_room.hpp"

namespace feltwire {

struct ControlOptions {
  asio::ip::address address;  // to listen on
  std::uint16_t port = 0;     // 0: the operating system chooses
  /// For TLS handshake and token together; a slower connection is closed.
  std::chrono::milliseconds handshake_timeout{5'000};
  std::chrono::milliseconds idle_timeout{60'000};  // a connection that sends no request ends
  /// Half of them, but no more than max_strangers, for connections without a valid token; half for
  /// those with one.
  std::size_t max_connections = 512;
  std::size_t max_strangers = 48;                 // each may have 60 KB of memory for its handshake
  std::size_t max_connections_per_network = 128;  // of either half (server/access/network.hpp)
  std::size_t max_connections_per_client = 64;    // with a valid token, by the client's name
  double handshake_rate = 50.0;                   // [1/s] connections of a network, for ever,
  double handshake_burst = 100.0;                 // and at once; others wait (ConnectionTurns)
  std::chrono::milliseconds handshake_patience{3'000};  // a connection that waits longer is closed
};

/// Totals of connections.
struct ControlCounters {
  std::uint64_t accepted = 0;
  std::uint64_t too_often = 0;    // closed before TLS: their network connects too often
  std::uint64_t crowded_out = 0;  // closed for newer ones: there were as many as there may be
  std::uint64_t failed = 0;       // TLS came to nothing: not 1.3, no certificate, no TLS at all
  std::uint64_t too_slow = 0;     // TLS or token took too long
};

/// The other end of a connection.
struct ControlPeer {
  asio::ip::address address;
  std::string token;   // id of the one it has shown; empty: none yet
  std::string client;  // the name of that token's holder
  bool waits = false;  // the answer may take long: the connection stays until it is given
};

/// Answers requests; the answer may be called later, on the control thread, exactly once. `peer`
/// lives until the answer is given. Until it has set peer.token a connection may send short frames
/// only, and a refusal ends it. Where the handler throws, or gives an answer that no frame holds,
/// the connection ends, and no other.
using ControlHandler = std::function<void(ControlPeer& peer, control::Message request,
                                          std::function<void(control::Message)> answer)>;

class ControlEndpoint {
 public:
  /// Binds and listens. With `client_authorities` (PEM) a client needs a certificate of theirs.
  /// Throws std::runtime_error in one line when it cannot. `io` runs on one thread and outlives
  /// this; the handler is called on that thread.
  ControlEndpoint(asio::io_context& io, const ControlOptions& options, const Identity& identity,
                  const std::string& client_authorities, ControlHandler handler);
  ~ControlEndpoint();

  /// Begins to accept.
  void start();

  /// New connections get this certificate, and need one of these authorities. On the thread of
  /// `io`.
  void renew(const Identity& identity, const std::string& client_authorities);

  /// Accepts again after an exception of an accepting handler; does nothing where it accepts
  /// already. On the thread of `io`.
  void keep_accepting();
  /// Ends the connections that no handler will ever go on with: an exception (no memory) took it
  /// away. Not in a handler of a connection; on the thread of `io`.
  void end_lost();
  /// Closes the acceptor and every connection. On the thread of `io`.
  void close();

  std::uint16_t port() const { return port_; }
  /// On the thread of `io`, or when it does not run.
  ControlCounters counters() const;

 private:
  class Connection;
  void accept();
  bool take();
  void accept_later();
  void open(ConnectionSlots::Id id, asio::ip::tcp::socket socket, const asio::ip::address& address);
  void make_known(Connection& connection);
  void end(std::optional<ConnectionSlots::Id> crowded_out);

  asio::io_context& io_;
  ControlOptions options_;
  asio::ssl::context tls_;
  ControlHandler handler_;
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer retry_;
  WaitingRoom waiting_room_;  // before TLS
  std::map<ConnectionSlots::Id, std::shared_ptr<Connection>> connections_;
  // Connections without and with a good token. Each connection is in one.
  ConnectionSlots strangers_, known_;
  bool accepting_ = false;    // a handler waits for a connection, or for the next try
  ControlCounters counters_;  // except too_often, which the waiting room counts
  std::uint16_t port_ = 0;
};

}  // namespace feltwire

#pragma once
// The control endpoint: TCP, frames of protocol/control.hpp, one thread.

#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/steady_timer.hpp>
#include <chrono>
#include <functional>
#include <memory>
#include <set>

#include "protocol/control.hpp"

namespace feltwire {

struct ControlOptions {
  asio::ip::address address;                       // to listen on
  std::uint16_t port = 0;                          // 0: the operating system chooses
  std::chrono::milliseconds idle_timeout{60'000};  // a connection that sends no request ends
  std::size_t max_connections = 256;
};

/// Answers requests; the answer may be called later, on the control thread, exactly once.
using ControlHandler =
    std::function<void(control::Message request, std::function<void(control::Message)> answer)>;

class ControlEndpoint {
 public:
  /// Binds and listens. Throws std::runtime_error in one line when it cannot. `io` runs on one
  /// thread and outlives this; the handler is called on that thread.
  ControlEndpoint(asio::io_context& io, const ControlOptions& options, ControlHandler handler);
  ~ControlEndpoint();

  /// Begins to accept.
  void start();
  /// Closes the acceptor and every connection. On the thread of `io`.
  void close();

  std::uint16_t port() const { return port_; }

 private:
  class Connection;
  void accept();

  asio::io_context& io_;
  ControlOptions options_;
  ControlHandler handler_;
  asio::ip::tcp::acceptor acceptor_;
  asio::steady_timer retry_;
  std::set<std::shared_ptr<Connection>> connections_;
  std::uint16_t port_ = 0;
};

}  // namespace feltwire

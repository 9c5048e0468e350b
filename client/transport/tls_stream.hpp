#pragma once
// A blocking TLS connection to a trusted server. Each step has a time limit.

#include <asio/io_context.hpp>
#include <asio/ip/address.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <asio/ssl/stream.hpp>
#include <chrono>
#include <optional>
#include <span>
#include <string>

#include "client/transport/control_client.hpp"

namespace feltwire {

class TlsStream {
 public:
  /// Connects and checks the server's certificate against the credentials. Sends nothing to a
  /// server that they do not trust. Throws SessionError, as do the functions below, and Cancelled
  /// if the thread's work is cancelled (core/base/cancellation.hpp).
  TlsStream(const ServerAccess& server, std::chrono::milliseconds timeout);
  TlsStream(const TlsStream&) = delete;
  TlsStream& operator=(const TlsStream&) = delete;

  void write(std::span<const std::uint8_t> bytes);
  /// Fills `bytes`.
  void read(std::span<std::uint8_t> bytes);

  /// The certificate that the client wants, and the one that the server showed.
  struct Pin {
    std::optional<Fingerprint> wanted, seen;
  };

  asio::ip::address peer() const { return stream_.lowest_layer().remote_endpoint().address(); }

 private:
  void connect();
  void handshake(const ServerAccess& server);
  /// Runs an operation until it ends or its time is over. `what` and `remedy` are for the message
  /// of either failure.
  template <class Start>
  void await(Start start, const std::string& what, const std::string& remedy);

  std::string server_;
  std::chrono::milliseconds timeout_;
  Pin pin_;
  asio::io_context io_;
  asio::ip::tcp::resolver::results_type found_;  // addresses of the host
  asio::ssl::context tls_;
  asio::ssl::stream<asio::ip::tcp::socket> stream_;
};

}  // namespace feltwire

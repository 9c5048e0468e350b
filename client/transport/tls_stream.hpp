#pragma once
// A TLS connection to a server that is known; blocking, each step with a time limit.

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
  /// Connects and checks the server's certificate against the credentials; sends nothing to a
  /// server that they do not trust. Throws SessionError, as do the functions below.
  TlsStream(const ServerAccess& server, std::chrono::milliseconds timeout);
  TlsStream(const TlsStream&) = delete;
  TlsStream& operator=(const TlsStream&) = delete;

  void write(std::span<const std::uint8_t> bytes);
  /// Fills `bytes`.
  void read(std::span<std::uint8_t> bytes);

  /// The certificate that will do, and the one that came.
  struct Pin {
    std::optional<Fingerprint> wanted, seen;
  };

  asio::ip::address peer() const { return stream_.lowest_layer().remote_endpoint().address(); }
  SessionKeys keys(std::uint64_t session, CipherSuite suite) const;

 private:
  void connect(const Endpoint& server);
  void handshake(const ServerAccess& server);
  /// Runs an operation to its end or the time limit; the remedy is for both kinds of failure.
  template <class Start>
  void await(Start start, const std::string& what, const std::string& remedy);

  std::string server_;
  std::chrono::milliseconds timeout_;
  Pin pin_;
  asio::io_context io_;
  asio::ssl::context tls_;
  mutable asio::ssl::stream<asio::ip::tcp::socket> stream_;
};

}  // namespace feltwire

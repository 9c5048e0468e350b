#pragma once
// A connection of the live page as bytes: TCP, or TLS over it.

#include <array>
#include <asio/ip/tcp.hpp>
#include <asio/ssl/context.hpp>
#include <cstdint>
#include <functional>
#include <memory>
#include <span>
#include <system_error>

#include "server/web/shared_bytes.hpp"

namespace feltwire::web {

/// At most one read and one write may be under way at a time; handlers are called on the thread of
/// the socket's io_context.
class Stream {
 public:
  using Done = std::function<void(const std::error_code&)>;
  using Read = std::function<void(const std::error_code&, std::span<const std::uint8_t>)>;

  virtual ~Stream() = default;
  /// Call it first.
  virtual void handshake(Done done) = 0;
  /// Reads the next bytes: at least one if there is no error.
  virtual void read(Read done) = 0;
  /// Writes all bytes.
  virtual void write(Output output, Done done) = 0;
  /// Ends writing; reading continues.
  virtual void end_writing() = 0;
  virtual void close() noexcept = 0;
};

/// `tls` null: plain TCP.
std::unique_ptr<Stream> make_stream(asio::ip::tcp::socket socket, asio::ssl::context* tls);

}  // namespace feltwire::web

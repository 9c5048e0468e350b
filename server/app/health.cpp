#include "server/app/health.hpp"

#include <array>
#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/ip/tcp.hpp>
#include <asio/read.hpp>
#include <asio/ssl/error.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>
#include <functional>
#include <stdexcept>
#include <vector>

#include "protocol/crypto/tls.hpp"
#include "protocol/wire/control.hpp"

namespace feltwire {
namespace {

using asio::ip::tcp;
using Error = std::error_code;

/// Returns a TLS context that accepts every certificate, because it only matters whether a server
/// answers.
asio::ssl::context any_server() {
  asio::ssl::context tls(asio::ssl::context::tls_client);
  require_tls_13(*tls.native_handle());
  return tls;
}

/// Connects, sends a question and reads the answer. Each step starts the next one. The question is
/// an empty frame: every server refuses it as malformed before it asks for a token, and does not
/// count it.
struct Question {
  asio::io_context io{1};
  asio::ssl::context tls = any_server();
  asio::ssl::stream<tcp::socket> stream{io, tls};
  std::array<std::uint8_t, control::kFrameLengthSize> frame{};  // question: a frame of length 0
  std::array<std::uint8_t, control::kFrameLengthSize> length{};
  std::vector<std::uint8_t> body;
  Error failed;
  bool answered = false;

  /// Returns a handler that runs `next` unless the step before it has failed.
  template <class Next>
  auto then(Next next) {
    return [this, next](const Error& error, std::size_t = 0) {
      failed = error;
      // A server that refuses a client without a certificate has answered, so it runs.
      answered = error.category() == asio::error::get_ssl_category() &&
                 ERR_GET_REASON(static_cast<unsigned long>(error.value())) ==
                     SSL_R_TLSV13_ALERT_CERTIFICATE_REQUIRED;
      if (!error) next();
    };
  }
  void ask(const tcp::endpoint& server) {
    stream.lowest_layer().async_connect(server, then([this] {
                                          stream.async_handshake(
                                              asio::ssl::stream_base::client, then([this] {
                                                asio::async_write(stream, asio::buffer(frame),
                                                                  then([this] { read(); }));
                                              }));
                                        }));
  }
  void read() {
    asio::async_read(stream, asio::buffer(length), then([this] {
                       const std::uint32_t size = control::frame_length(length);
                       if (size == 0 || size > control::kMaxFrame) return;
                       body.resize(size);
                       asio::async_read(stream, asio::buffer(body), then([this] {
                                          answered = control::decode(body).has_value();
                                        }));
                     }));
  }
};

/// Returns the address at which to ask the server: the loopback address of the same family if the
/// server listens on all addresses.
asio::ip::address reachable(const std::string& address) {
  asio::ip::address listening = asio::ip::make_address(address);
  if (!listening.is_unspecified()) return listening;
  if (listening.is_v6()) return asio::ip::address_v6::loopback();
  return asio::ip::address_v4::loopback();
}

}  // namespace

void check_health(const std::string& address, int port, std::chrono::milliseconds timeout) {
  const tcp::endpoint server(reachable(address), static_cast<std::uint16_t>(port));
  Question question;
  question.ask(server);
  question.io.run_for(timeout);
  if (question.answered) return;
  throw std::runtime_error(
      "no feltwire server answers at " + address + " port " + std::to_string(port) + ": " +
      (question.failed ? question.failed.message() : "no answer within the time allowed"));
}

}  // namespace feltwire

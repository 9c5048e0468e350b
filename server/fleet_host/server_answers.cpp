#include "server/fleet_host/server_answers.hpp"

#include <openssl/ssl.h>

#include <array>
#include <asio/buffer.hpp>
#include <asio/io_context.hpp>
#include <asio/read.hpp>
#include <asio/ssl/error.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>
#include <memory>
#include <system_error>
#include <vector>

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
  const std::optional<Fingerprint>& wanted;
  Error failed;
  bool answered = false;

  explicit Question(const std::optional<Fingerprint>& fingerprint) : wanted(fingerprint) {}

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
                                                if (!known()) return;
                                                asio::async_write(stream, asio::buffer(frame),
                                                                  then([this] { read(); }));
                                              }));
                                        }));
  }
  /// Whether it is the wanted server.
  bool known() {
    if (!wanted) return true;
    const std::unique_ptr<X509, decltype(&X509_free)> shown(
        SSL_get1_peer_certificate(stream.native_handle()), &X509_free);
    if (shown && fingerprint(*shown) == *wanted) return true;
    failed = std::make_error_code(std::errc::permission_denied);
    return false;
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

}  // namespace

std::optional<std::string> silence_of(const tcp::endpoint& server,
                                      std::chrono::milliseconds timeout,
                                      const std::optional<Fingerprint>& wanted) {
  Question question(wanted);
  question.ask(server);
  question.io.run_for(timeout);
  if (question.answered) return std::nullopt;
  return question.failed ? question.failed.message() : "no answer within the time allowed";
}

}  // namespace feltwire

#include "server/web/stream.hpp"

#include <asio/buffer.hpp>
#include <asio/post.hpp>
#include <asio/write.hpp>
#include <utility>

#include "server/access/tls_socket.hpp"

namespace feltwire::web {
namespace {

using asio::ip::tcp;

/// The common part of Plain and Tls. It reads from `layer_` and writes to it.
template <class Layer>
class Layered : public Stream {
 public:
  template <class... Parts>
  explicit Layered(Parts&&... parts) : layer_(std::forward<Parts>(parts)...) {}

  void read(Read done) override {
    layer_.async_read_some(
        asio::buffer(input_),
        [this, done = std::move(done)](const std::error_code& error, std::size_t count) {
          done(error, std::span(input_).first(count));
        });
  }
  void write(Output output, Done done) override {
    output_ = std::move(output);
    const auto shared = output_.shared.bytes();
    const std::array<asio::const_buffer, 2> parts = {asio::buffer(output_.own),
                                                     asio::buffer(shared.data(), shared.size())};
    asio::async_write(layer_, parts,
                      [this, done = std::move(done)](const std::error_code& error, std::size_t) {
                        output_ = {};
                        done(error);
                      });
  }
  void close() noexcept override {
    std::error_code ignored;
    socket().shutdown(tcp::socket::shutdown_both, ignored);
    socket().close(ignored);
  }

 protected:
  tcp::socket& socket() {
    if constexpr (std::is_same_v<Layer, tcp::socket>)
      return layer_;
    else
      return layer_.next_layer();
  }
  static constexpr std::size_t kAtOnce = 4096;
  Layer layer_;
  std::array<std::uint8_t, kAtOnce> input_{};
  Output output_;  // the output that is being written
};

class Plain : public Layered<tcp::socket> {
 public:
  using Layered::Layered;
  void handshake(Done done) override {
    asio::post(layer_.get_executor(), [done = std::move(done)] { done({}); });
  }
  void end_writing() override {
    std::error_code ignored;
    layer_.shutdown(tcp::socket::shutdown_send, ignored);
  }
};

class Tls : public Layered<TlsSocket> {
 public:
  Tls(tcp::socket socket, asio::ssl::context& tls)
      : Layered(std::move(socket), *tls.native_handle()) {}
  void handshake(Done done) override { layer_.async_handshake(std::move(done)); }
  /// Ends the TCP output, without an end of TLS: an HTTP answer states its length, so the client
  /// sees that it is complete.
  void end_writing() override {
    std::error_code ignored;
    socket().shutdown(tcp::socket::shutdown_send, ignored);
  }
};

}  // namespace

std::unique_ptr<Stream> make_stream(tcp::socket socket, asio::ssl::context* tls) {
  if (tls == nullptr) return std::make_unique<Plain>(std::move(socket));
  return std::make_unique<Tls>(std::move(socket), *tls);
}

}  // namespace feltwire::web

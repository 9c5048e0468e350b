#include "server/web/stream.hpp"

#include <asio/buffer.hpp>
#include <asio/post.hpp>
#include <asio/ssl/stream.hpp>
#include <asio/write.hpp>
#include <utility>

#include "protocol/crypto/tls.hpp"

namespace feltwire::web {
namespace {

using asio::ip::tcp;

/// The common part of both kinds. It reads from a Layer and writes to it.
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
  void write(std::vector<std::uint8_t> bytes, Done done) override {
    output_ = std::move(bytes);
    asio::async_write(
        layer_, asio::buffer(output_),
        [done = std::move(done)](const std::error_code& error, std::size_t) { done(error); });
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
  std::vector<std::uint8_t> output_;
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

class Tls : public Layered<asio::ssl::stream<tcp::socket>> {
 public:
  Tls(tcp::socket socket, asio::ssl::context& tls)
      : Layered(std::move(socket), new_tls_connection(*tls.native_handle())) {
    require_buffers(*layer_.native_handle());
  }
  void handshake(Done done) override {
    layer_.async_handshake(asio::ssl::stream_base::server,
                           [done = std::move(done)](const std::error_code& error) { done(error); });
  }
  /// The answer has its length, so that no end of TLS is needed to see that it is whole.
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

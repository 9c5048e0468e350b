#include "server/control.hpp"

#include <array>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <vector>

#include "server/listen_error.hpp"

namespace feltwire {

using asio::ip::tcp;

/// One request, one answer, in turn.
class ControlEndpoint::Connection : public std::enable_shared_from_this<Connection> {
 public:
  Connection(ControlEndpoint& endpoint, tcp::socket socket)
      : endpoint_(endpoint), socket_(std::move(socket)), idle_(endpoint.io_) {}

  void start() { read_length(); }

  /// Answers before any request, and ends.
  void refuse(control::Refused refusal) {
    restart_idle_timer();
    ends_after_answer_ = true;
    write(std::move(refusal));
  }

  void close() {
    if (closed_) return;
    closed_ = true;
    std::error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_both, ignored);
    socket_.close(ignored);
    idle_.cancel();
  }

 private:
  /// Every way out: the endpoint forgets the connection, and with the last handler it is gone.
  void end() {
    close();
    endpoint_.connections_.erase(shared_from_this());
  }

  void restart_idle_timer() {
    idle_.expires_after(endpoint_.options_.idle_timeout);
    idle_.async_wait([self = shared_from_this()](const std::error_code& error) {
      if (!error && !self->closed_) self->end();
    });
  }

  void read_length() {
    restart_idle_timer();
    asio::async_read(socket_, asio::buffer(length_),
                     [self = shared_from_this()](const std::error_code& error, std::size_t) {
                       if (self->closed_) return;
                       if (error) return self->end();
                       self->read_body();
                     });
  }

  void read_body() {
    const std::uint32_t length = control::frame_length(length_);
    if (length == 0 || length > control::kMaxFrame)
      return refuse_malformed("a frame of " + std::to_string(length) + " bytes; 1 to " +
                              std::to_string(control::kMaxFrame) + " are read");
    body_.resize(length);
    asio::async_read(socket_, asio::buffer(body_),
                     [self = shared_from_this()](const std::error_code& error, std::size_t) {
                       if (self->closed_) return;
                       if (error) return self->end();
                       self->handle();
                     });
  }

  void handle() {
    std::optional<control::Message> request = control::decode(body_);
    if (!request) return refuse_malformed("the frame holds no control message of this version");
    endpoint_.handler_(
        std::move(*request), [self = shared_from_this()](const control::Message& answer) {
          if (self->closed_) return;
          if (const auto* refused = std::get_if<control::Refused>(&answer))
            self->ends_after_answer_ = refused->code == control::RefusalCode::malformed;
          self->write(answer);
        });
  }

  void refuse_malformed(std::string reason) {
    ends_after_answer_ = true;
    write(control::Refused{control::RefusalCode::malformed, std::move(reason)});
  }

  void write(const control::Message& answer) {
    frame_ = control::encode(answer);
    asio::async_write(socket_, asio::buffer(frame_),
                      [self = shared_from_this()](const std::error_code& error, std::size_t) {
                        if (self->closed_) return;
                        if (error) return self->end();
                        if (self->ends_after_answer_) return self->drain();
                        self->read_length();
                      });
  }

  /// Says that nothing more comes and reads on until the other side closes too (or the idle timer
  /// ends it): closing over unread bytes would reset the connection and lose the refusal.
  void drain() {
    std::error_code ignored;
    socket_.shutdown(tcp::socket::shutdown_send, ignored);
    discard();
  }

  void discard() {
    body_.resize(4096);
    socket_.async_read_some(asio::buffer(body_),
                            [self = shared_from_this()](const std::error_code& error, std::size_t) {
                              if (self->closed_) return;
                              if (error) return self->end();
                              self->discard();
                            });
  }

  ControlEndpoint& endpoint_;
  tcp::socket socket_;
  asio::steady_timer idle_;
  std::array<std::uint8_t, control::kFrameLengthSize> length_{};
  std::vector<std::uint8_t> body_, frame_;
  bool ends_after_answer_ = false;
  bool closed_ = false;
};

ControlEndpoint::ControlEndpoint(asio::io_context& io, const ControlOptions& options,
                                 ControlHandler handler)
    : io_(io), options_(options), handler_(std::move(handler)), acceptor_(io), retry_(io) {
  const tcp::endpoint endpoint(options.address, options.port);
  try {
    acceptor_.open(endpoint.protocol());
    // Connections of a server that ended a moment ago must not keep the port; a living one still
    // does.
    acceptor_.set_option(tcp::acceptor::reuse_address(true));
    serve_both_families(acceptor_, options.address);
    acceptor_.bind(endpoint);
    acceptor_.listen();
    port_ = acceptor_.local_endpoint().port();
  } catch (const std::system_error& error) {
    throw listen_error("tcp", options.address, options.port, error.code());
  }
}

ControlEndpoint::~ControlEndpoint() = default;

void ControlEndpoint::start() { accept(); }

void ControlEndpoint::accept() {
  acceptor_.async_accept([this](const std::error_code& error, tcp::socket socket) {
    if (error == asio::error::operation_aborted || !acceptor_.is_open()) return;
    if (error) {
      // Out of descriptors, say: what is open goes on, and a moment later there may be one.
      retry_.expires_after(std::chrono::milliseconds(100));
      retry_.async_wait([this](const std::error_code& cancelled) {
        if (!cancelled) accept();
      });
      return;
    }
    // A refusal stays open until it was read, so there is an end to refusals too: beyond it the
    // socket is dropped, and so closed.
    if (connections_.size() >= 2 * options_.max_connections) return accept();
    auto connection = std::make_shared<Connection>(*this, std::move(socket));
    const bool full = connections_.size() >= options_.max_connections;
    connections_.insert(connection);
    if (full)
      connection->refuse({control::RefusalCode::full, "too many control connections; try again"});
    else
      connection->start();
    accept();
  });
}

void ControlEndpoint::close() {
  std::error_code ignored;
  acceptor_.close(ignored);
  retry_.cancel();
  for (const auto& connection : connections_) connection->close();
  connections_.clear();
}

}  // namespace feltwire

#include "server/control/control_endpoint.hpp"

#include <spdlog/spdlog.h>

#include <algorithm>
#include <array>
#include <asio/read.hpp>
#include <asio/write.hpp>
#include <utility>
#include <vector>

#include "protocol/crypto/tls.hpp"
#include "server/access/listening.hpp"
#include "server/access/tls_socket.hpp"

namespace feltwire {

using asio::ip::tcp;
using control::RefusalCode;
using Error = std::error_code;

namespace {

asio::ssl::context server_context(const Identity& identity, const std::string& client_authorities) {
  asio::ssl::context tls = server_tls(identity);
  if (!client_authorities.empty()) {
    tls.add_certificate_authority(asio::buffer(client_authorities));
    tls.set_verify_mode(asio::ssl::verify_peer | asio::ssl::verify_fail_if_no_peer_cert);
  }
  return tls;
}

/// Returns limits on the connections that wait for TLS: half of the allowed number of open
/// connections, in total and for each network.
TurnLimits turn_limits(const ControlOptions& options) {
  TurnLimits limits;
  limits.rate = options.handshake_rate;
  limits.burst = options.handshake_burst;
  limits.patience = options.handshake_patience;
  limits.waiting = std::max<std::size_t>(1, options.max_connections / 2);
  limits.waiting_of_network = std::max<std::size_t>(1, options.max_connections_per_network / 2);
  return limits;
}

}  // namespace

/// A control connection: a TLS handshake, then one request and its answer at a time.
class ControlEndpoint::Connection : public std::enable_shared_from_this<Connection> {
 private:
  /// Returns a handler that calls `work` and keeps this connection alive. The handler does nothing
  /// after close(). If `work` throws, only this connection ends.
  template <class Work>
  auto safely(Work work) {
    return [self = shared_from_this(), work = std::move(work)](const auto&... results) {
      if (self->closed_) return;
      try {
        work(results...);
      } catch (const std::exception& error) {
        self->fail(error);
      }
    };
  }
  /// Returns a handler like that of safely(), for the next step of the connection. At most one such
  /// handler is pending. If it is destroyed without a call, no further step follows (see lost()).
  template <class Work>
  auto then(Work work) {
    return [going_on = going_on_, handler = safely(std::move(work))](const auto&... results) {
      handler(results...);
    };
  }

 public:
  Connection(ControlEndpoint& endpoint, ConnectionSlots::Id id, tcp::socket socket,
             const asio::ip::address& address)
      : endpoint_(endpoint),
        id_(id),
        stream_(std::move(socket), *endpoint.tls_.native_handle()),
        deadline_(endpoint.io_) {
    peer_.address = address;
  }
  ~Connection() { wipe_buffers(); }
  Connection(const Connection&) = delete;
  Connection& operator=(const Connection&) = delete;

  void start() {
    set_deadline(endpoint_.options_.handshake_timeout);
    stream_.async_handshake(then([this](const Error& error) {
      if (error) {
        ++endpoint_.counters_.failed;
        return end();
      }
      read_length();
    }));
  }

  /// Returns whether the pending handler of then() was destroyed without a call. The cause is an
  /// exception between two steps, or an answer that was dropped. Do not call lost() in a handler of
  /// this connection.
  bool lost() const { return going_on_.use_count() == 1; }

  ConnectionSlots::Id id() const { return id_; }
  const ControlPeer& peer() const { return peer_; }

  /// Reports the outcome of this connection to waiting_room_, which uses it to order later
  /// connections of the same host. Only the first report counts.
  void judge(ConnectionTurns::Outcome outcome) {
    if (judged_) return;
    endpoint_.waiting_room_.judge(peer_.address, outcome);
    judged_ = true;
  }

  /// Closes this connection and removes it from the endpoint. The last handler then destroys the
  /// object.
  void end() {
    close();
    judge(ConnectionTurns::Outcome::none);
    endpoint_.strangers_.leave(id_);
    endpoint_.known_.leave(id_);
    endpoint_.connections_.erase(id_);
  }

  void close() {
    if (closed_) return;
    closed_ = true;
    Error ignored;
    socket().shutdown(tcp::socket::shutdown_both, ignored);
    socket().close(ignored);
    deadline_.cancel();
  }

  /// Logs the exception and ends this connection. Other connections continue.
  void fail(const std::exception& error) noexcept {
    try {
      spdlog::error("a control connection from {} ends, the server failed at it: {}",
                    peer_.address.to_string(), error.what());
    } catch (const std::exception&) {
      // There is no memory to log the error. The connection still ends.
    }
    end();
  }

 private:
  tcp::socket& socket() { return stream_.next_layer(); }
  bool stranger() const { return peer_.token.empty(); }

  /// Wipes and frees the request and the answer: they may hold a token or the secrets of a session,
  /// and a connection that waits for its next request must not hold memory.
  void wipe_buffers() noexcept {
    for (auto* buffer : {&body_, &frame_}) {
      wipe(*buffer);
      *buffer = std::vector<std::uint8_t>();
    }
  }

  void set_deadline(std::chrono::milliseconds timeout) {
    deadline_.expires_after(timeout);
    deadline_.async_wait(safely([this](const Error& error) {
      if (error) return;
      if (stranger() && !ends_after_answer_) ++endpoint_.counters_.too_slow;
      end();
    }));
  }

  void read_length() {
    // A connection without a token keeps the deadline that start() has set.
    if (!stranger()) {
      set_deadline(endpoint_.options_.idle_timeout);
      endpoint_.known_.renew(id_);
    }
    asio::async_read(stream_, asio::buffer(length_), then([this](const Error& error, std::size_t) {
                       if (error) return end();
                       read_body();
                     }));
  }

  void read_body() {
    const std::uint32_t length = control::frame_length(length_);
    const std::size_t most = stranger() ? control::kMaxFirstFrame : control::kMaxFrame;
    if (length == 0 || length > most)
      return refuse_malformed("a frame of " + std::to_string(length) + " bytes; 1 to " +
                              std::to_string(most) + " are read");
    body_.resize(length);
    asio::async_read(stream_, asio::buffer(body_), then([this](const Error& error, std::size_t) {
                       if (error) return end();
                       handle();
                     }));
  }

  void handle() {
    std::optional<control::Message> request = control::decode(body_);
    wipe_buffers();
    if (!request) return refuse_malformed("the frame holds no control message of this version");
    endpoint_.handler_(peer_, std::move(*request), then([this](const control::Message& answer) {
                         if (const auto* refused = std::get_if<control::Refused>(&answer))
                           ends_after_answer_ =
                               stranger() || refused->code == RefusalCode::malformed;
                         if (!stranger()) endpoint_.make_known(*this);
                         if (std::exchange(peer_.waits, false))
                           set_deadline(endpoint_.options_.idle_timeout);
                         write(answer);
                       }));
    if (peer_.waits) deadline_.cancel();
  }

  void refuse_malformed(std::string reason) {
    ends_after_answer_ = true;
    write(control::Refused{RefusalCode::malformed, std::move(reason)});
  }

  void write(const control::Message& answer) {
    frame_ = control::encode(answer);
    asio::async_write(stream_, asio::buffer(frame_), then([this](const Error& error, std::size_t) {
                        if (error) return end();
                        wipe_buffers();
                        if (ends_after_answer_) return say_end();
                        read_length();
                      }));
  }

  /// Ends TLS, then ends the TCP output. Then reads and discards until the client closes, until it
  /// has sent more than the longest request, or until the deadline. Closing a socket with unread
  /// bytes would reset the connection, and the client would lose the refusal.
  void say_end() {
    stream_.async_shutdown(then([this](const Error&) {
      Error ignored;
      socket().shutdown(tcp::socket::shutdown_send, ignored);
      discard();
    }));
  }

  void discard() {
    constexpr std::size_t kAtOnce = 4096;
    body_.resize(kAtOnce);
    socket().async_read_some(asio::buffer(body_),
                             then([this](const Error& error, std::size_t size) {
                               discarded_ += size;
                               if (error || discarded_ > control::kMaxFrame) return end();
                               discard();
                             }));
  }

  ControlEndpoint& endpoint_;
  const ConnectionSlots::Id id_;
  TlsSocket stream_;
  asio::steady_timer deadline_;
  ControlPeer peer_;
  std::array<std::uint8_t, control::kFrameLengthSize> length_{};
  std::vector<std::uint8_t> body_, frame_;
  std::size_t discarded_ = 0;  // [bytes] read by discard()
  // then() copies this pointer into each handler, so that lost() can count the handlers.
  std::shared_ptr<const bool> going_on_ = std::make_shared<const bool>(true);
  bool ends_after_answer_ = false;
  bool closed_ = false;
  bool judged_ = false;
};

ControlEndpoint::ControlEndpoint(asio::io_context& io, const ControlOptions& options,
                                 const Identity& identity, const std::string& client_authorities,
                                 ControlHandler handler)
    : io_(io),
      options_(options),
      tls_(server_context(identity, client_authorities)),
      handler_(std::move(handler)),
      acceptor_(io),
      retry_(io),
      waiting_room_(
          io, turn_limits(options),
          [this](ConnectionSlots::Id id, tcp::socket socket, const asio::ip::address& address) {
            open(id, std::move(socket), address);
          }),
      strangers_(std::clamp<std::size_t>(options.max_connections / 2, 1, options.max_strangers),
                 options.max_connections_per_network),
      known_(std::max<std::size_t>(1, options.max_connections - options.max_connections / 2),
             options.max_connections_per_network, options.max_connections_per_client) {
  port_ = listen_on(acceptor_, {options.address, options.port});
}

ControlEndpoint::~ControlEndpoint() = default;

void ControlEndpoint::start() { accept(); }

void ControlEndpoint::renew(const Identity& identity, const std::string& client_authorities) {
  tls_ = server_context(identity, client_authorities);
}

/// Waits until a connection arrives, and accepts it with take(). Asio's async_accept() would call
/// no handler if there is no memory for the new connection. No further connection would be
/// accepted.
void ControlEndpoint::accept() {
  acceptor_.async_wait(tcp::acceptor::wait_read, [this](const Error& error) {
    accepting_ = false;
    if (error == asio::error::operation_aborted || !acceptor_.is_open()) return;
    if (error || !take()) return accept_later();
    accept();
  });
  accepting_ = true;
}

/// Accepts a connection and passes it to the waiting room. Returns false if the system refuses it,
/// for example because no file descriptor is free.
bool ControlEndpoint::take() {
  try {
    Error error;
    tcp::socket socket(io_);
    acceptor_.accept(socket, error);
    if (!error) waiting_room_.arrive(std::move(socket));
    return !error || error == asio::error::would_block ||
           error == asio::error::connection_aborted;  // the client has gone
  } catch (const std::exception& failure) {
    spdlog::error("a control connection could not be taken: {}", failure.what());
    return true;
  }
}

/// Tries again after a pause, because a file descriptor may be free by then. Open connections
/// continue.
void ControlEndpoint::accept_later() {
  retry_.expires_after(std::chrono::milliseconds(100));
  retry_.async_wait([this](const Error& cancelled) {
    accepting_ = false;
    if (!cancelled) accept();
  });
  accepting_ = true;
}

void ControlEndpoint::keep_accepting() {
  if (!acceptor_.is_open()) return;
  if (!accepting_) accept();
  waiting_room_.keep_looking();
}

void ControlEndpoint::end_lost() {
  std::vector<std::shared_ptr<Connection>> lost;
  for (const auto& [id, connection] : connections_)
    if (connection->lost()) lost.push_back(connection);
  for (const auto& connection : lost) connection->end();
}

/// Begins the TLS handshake of a connection that the waiting room has admitted.
void ControlEndpoint::open(ConnectionSlots::Id id, tcp::socket socket,
                           const asio::ip::address& address) {
  Error ignored;
  socket.set_option(tcp::no_delay(true), ignored);  // send each answer at once
  ++counters_.accepted;
  std::shared_ptr<Connection> connection;
  try {
    connection = std::make_shared<Connection>(*this, id, std::move(socket), address);
    connections_.emplace(id, connection);
  } catch (const std::exception&) {
    waiting_room_.judge(address, ConnectionTurns::Outcome::none);
    throw;
  }
  try {
    end(strangers_.take(id, network_of(address), ConnectionSlots::member_of(address)));
    connection->start();
  } catch (const std::exception& error) {
    connection->fail(error);
  }
}

/// Moves a connection that has shown a valid token from strangers_ to known_. So connections
/// without a token cannot displace it. If known_ is full, one of its connections ends
/// (ConnectionSlots says which).
void ControlEndpoint::make_known(Connection& connection) {
  if (!strangers_.leave(connection.id())) return;
  connection.judge(ConnectionTurns::Outcome::good);
  end(known_.take(connection.id(), network_of(connection.peer().address),
                  connection.peer().client));
}

void ControlEndpoint::end(std::optional<ConnectionSlots::Id> crowded_out) {
  if (!crowded_out) return;
  ++counters_.crowded_out;
  const auto found = connections_.find(*crowded_out);
  if (found == connections_.end()) return;
  // This copy keeps the object alive, because end() removes the connection from the map.
  const std::shared_ptr<Connection> connection = found->second;
  connection->end();
}

ControlCounters ControlEndpoint::counters() const {
  ControlCounters all = counters_;
  all.too_often = waiting_room_.sent_away();
  return all;
}

void ControlEndpoint::close() {
  Error ignored;
  acceptor_.close(ignored);
  retry_.cancel();
  waiting_room_.close();
  for (const auto& [id, connection] : connections_) connection->close();
  connections_.clear();
}

}  // namespace feltwire

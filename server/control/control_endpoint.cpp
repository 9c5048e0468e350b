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

/// Half as many connections may wait as may be open, also within each network.
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

/// A control connection: TLS, then requests and answers in turn.
class ControlEndpoint::Connection : public std::enable_shared_from_this<Connection> {
 private:
  /// Returns a handler that keeps this connection alive and does nothing once it is closed. If
  /// `work` throws, only this connection ends.
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
  /// Like safely(), for the next step of the connection. At most one such handler is pending. If it
  /// is lost, no other follows (see lost()).
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
    peer_.keys = [this](std::uint64_t session, CipherSuite suite) {
      return export_keys(*stream_.native_handle(), session, suite);
    };
  }

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

  /// Whether its next handler was lost: by an exception between two steps of an operation, or with
  /// a dropped answer. Do not call it in a handler.
  bool lost() const { return going_on_.use_count() == 1; }

  ConnectionSlots::Id id() const { return id_; }
  const ControlPeer& peer() const { return peer_; }

  /// Reports the outcome for the turns of other connections; only the first report counts.
  void judge(ConnectionTurns::Outcome outcome) {
    if (judged_) return;
    endpoint_.waiting_room_.judge(peer_.address, outcome);
    judged_ = true;
  }

  /// Ends in every case: the endpoint forgets the connection, and its last handler destroys it.
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

  /// After an exception this connection ends; the others continue.
  void fail(const std::exception& error) noexcept {
    try {
      spdlog::error("a control connection from {} ends, the server failed at it: {}",
                    peer_.address.to_string(), error.what());
    } catch (const std::exception&) {
      // No memory for a line in the log; the connection still ends.
    }
    end();
  }

 private:
  tcp::socket& socket() { return stream_.next_layer(); }
  bool stranger() const { return peer_.token.empty(); }

  void set_deadline(std::chrono::milliseconds timeout) {
    deadline_.expires_after(timeout);
    deadline_.async_wait(safely([this](const Error& error) {
      if (error) return;
      if (stranger() && !ends_after_answer_) ++endpoint_.counters_.too_slow;
      end();
    }));
  }

  void read_length() {
    // The deadline of a stranger runs since its arrival.
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
    if (stranger()) wipe(body_);
    // A waiting connection must not keep its last request or answer in memory.
    body_ = std::vector<std::uint8_t>();
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
                        frame_ = std::vector<std::uint8_t>();
                        if (ends_after_answer_) return say_end();
                        read_length();
                      }));
  }

  /// Signals the end (TLS, then TCP). Then reads until the other side closes, sends more than any
  /// request has, or reaches the deadline. Closing with unread bytes would reset the connection and
  /// lose the refusal.
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
  std::size_t discarded_ = 0;                                                  // [bytes]
  std::shared_ptr<const bool> going_on_ = std::make_shared<const bool>(true);  // in handlers
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

/// Waits for a connection, and accepts it in our own handler. If Asio accepted it without memory
/// for it, Asio would call no handler, and no further connection would be accepted.
void ControlEndpoint::accept() {
  acceptor_.async_wait(tcp::acceptor::wait_read, [this](const Error& error) {
    accepting_ = false;
    if (error == asio::error::operation_aborted || !acceptor_.is_open()) return;
    if (error || !take()) return accept_later();
    accept();
  });
  accepting_ = true;
}

/// False if a connection waits but the system cannot give it.
bool ControlEndpoint::take() {
  try {
    Error error;
    tcp::socket socket(io_);
    acceptor_.accept(socket, error);
    if (!error) waiting_room_.arrive(std::move(socket));
    return !error || error == asio::error::would_block ||
           error == asio::error::connection_aborted;  // it has gone meanwhile
  } catch (const std::exception& failure) {
    spdlog::error("a control connection could not be taken: {}", failure.what());
    return true;
  }
}

/// For example no descriptor is free: open connections continue, and one may be free later.
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

/// Begins TLS with a connection whose turn it is.
void ControlEndpoint::open(ConnectionSlots::Id id, tcp::socket socket,
                           const asio::ip::address& address) {
  Error ignored;
  socket.set_option(tcp::no_delay(true), ignored);  // an answer waits for no acknowledgement
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

/// The connection has shown a good token, so no stranger can take its place. If the places for such
/// connections are short, the one idle for the longest time loses its place: in the network with
/// the most connections, and there of the client's name with the most.
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
  // Keep it alive: end() removes the connection from the map.
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

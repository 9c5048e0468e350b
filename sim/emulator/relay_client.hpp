#pragma once
// A client of the relay: its socket to the server, and its link.

#include <array>
#include <asio/ip/udp.hpp>
#include <asio/steady_timer.hpp>
#include <functional>
#include <memory>
#include <optional>

#include "client/emulated_link/link.hpp"

namespace feltwire {

inline constexpr int kBurst = 64;  // datagrams taken before others have their turn

/// Shared by its handlers; lives until they have run after close().
class RelayClient : public std::enable_shared_from_this<RelayClient> {
 public:
  /// Sends to the client; false if the system did not accept it.
  using SendBack = std::function<bool(Bytes)>;

  /// Opens the socket to the server's scene. Throws asio::system_error.
  RelayClient(const asio::any_io_executor& executor, const asio::ip::udp::endpoint& scene,
              std::unique_ptr<TwoWayLink> link, SendBack send_back);

  /// Begins to listen to the server.
  void start() { await_server(); }
  /// A datagram of the client.
  void enter(Bytes datagram, Nanoseconds now);
  /// Ends it; the counters stay.
  void close();

  const TwoWayLink& link() const { return *link_; }
  /// When the client last sent.
  Nanoseconds last_heard() const { return last_heard_; }
  /// Datagrams that left the link and that the system did not accept.
  std::uint64_t unsent() const { return unsent_; }

 private:
  void await_server();
  void pump();

  asio::ip::udp::socket server_;
  asio::steady_timer timer_;
  std::unique_ptr<TwoWayLink> link_;
  SendBack send_back_;
  std::optional<Nanoseconds> armed_;  // the time of the timer
  Nanoseconds last_heard_{0};
  std::uint64_t unsent_ = 0;
  std::array<std::uint8_t, kMaxDatagram + 1> buffer_{};
};

/// The clock of the relay.
inline Nanoseconds relay_now() { return std::chrono::steady_clock::now().time_since_epoch(); }

}  // namespace feltwire

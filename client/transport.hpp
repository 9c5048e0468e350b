#pragma once
// The datagrams of one session: samples out, replies in, through an emulated link where one is
// given. Never blocks, allocates or throws once it stands.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "client/control_client.hpp"
#include "client/conversation.hpp"
#include "client/link/link.hpp"

namespace feltwire {

struct TransportStatistics {
  std::uint64_t sent = 0;         // datagrams that the system took
  std::uint64_t send_failed = 0;  // the system took none: buffer full, peer's port closed, no route
  std::uint64_t too_long = 0;     // longer than the path to the server takes
  std::uint64_t rerouted = 0;     // times that another way to the server was looked for
  std::uint64_t received = 0;     // datagrams, before any check
  std::array<std::uint64_t, kDropReasons> dropped{};
};

/// Where a session's datagrams go, and how.
struct SessionAddress {
  Address server;
  std::uint64_t session = 0;
  SessionKeys keys;
};

class Transport {
 public:
  enum class Arrival { nothing, reply, goodbye };

  /// Opens a UDP socket to the session's scene. `parameters` as granted; `rotation`: orientation
  /// and torque travel too. With a `link` every datagram goes through it, and the caller must
  /// pass() the time. `scale`: of a position deadband. Datagrams are marked with `dscp`
  /// (protocol/udp_socket.hpp) and never cut into fragments: where the path takes no datagrams as
  /// long, they carry fewer samples. Throws SessionError.
  Transport(const SessionAddress& to, const SessionParameters& parameters, bool rotation,
            std::unique_ptr<TwoWayLink> link = nullptr, const PositionScale& scale = {},
            int dscp = 0);
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  /// Goes on with another session, of the same address family, through the same socket: numbers
  /// begin anew, what was on its way is no longer listened to. False when the system has no way
  /// there or cannot do its cipher suite; then the old session stays.
  bool resume(const SessionAddress& to) noexcept;

  /// Has the system choose anew by which of its addresses the server is reached: the one at first
  /// may be gone (another network, another cell). The port changes too; the server follows. Done by
  /// itself where sending fails for want of a way. False when there is none now.
  bool reroute() noexcept;

  /// To wait for replies on.
  int descriptor() const { return socket_; }

  /// Null without one.
  const TwoWayLink* link() const { return link_.get(); }
  /// When a datagram leaves the link: pass() and receive() are due then.
  std::optional<Nanoseconds> next_due() const noexcept {
    return link_ ? link_->next_due() : std::nullopt;
  }
  /// It is `now`, for this and the calls that follow: sends what leaves the link, lets what has
  /// come enter it. For transports with a link.
  void pass(Nanoseconds now) noexcept;

  /// To be given every sample: sends the datagram that is due with it. False when none is.
  bool send(const Sample& sample) noexcept;

  /// Takes the next datagram that has arrived and is good; bad ones are counted and skipped, up to
  /// kBurst of them, so that a flood costs the loop no more than that. `reply` or `reason` is
  /// filled, as the result says.
  Arrival receive(Reply& reply, GoodbyeReason& reason) noexcept;
  static constexpr int kBurst = 64;

  /// What the reply received last had for an observer's eyes; null: nothing. Lives until the next
  /// receive().
  const SceneView* view() const { return conversation_.view(); }

  /// Tells the server that this client leaves; three times, as no answer comes, and past the link,
  /// as nobody may be there to wait for what it holds.
  void goodbye() noexcept;

  TransportStatistics statistics() const {
    TransportStatistics all = statistics_;
    all.dropped = conversation_.dropped();
    return all;
  }

 private:
  void transmit(Bytes datagram) noexcept;
  void transmit_due() noexcept;
  void shorten() noexcept;
  std::optional<Bytes> take() noexcept;

  bool connect_to(const Address& server) noexcept;

  int socket_ = -1;
  Address server_;
  Conversation conversation_;
  std::array<std::uint8_t, kMaxDatagram + 1> buffer_;  // one more: what is too long shows
  TransportStatistics statistics_;
  std::unique_ptr<TwoWayLink> link_;
  Nanoseconds now_{0};  // with a link
};

}  // namespace feltwire

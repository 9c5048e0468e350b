#pragma once
// The datagrams of one session: samples out, replies in. After its construction it never blocks,
// allocates or throws.

#include <array>
#include <cstdint>
#include <memory>
#include <optional>

#include "client/transport/control_client.hpp"
#include "client/transport/datagram_port.hpp"
#include "client/transport/datagram_session.hpp"

namespace feltwire {

struct TransportStatistics : PortStatistics {
  std::array<std::uint64_t, kDropReasons> dropped{};
  std::uint64_t shortened = 0;  // replies that the server shortened, because the path is short
  int pace = 1;  // most packet intervals between two datagrams, as a server without time asked
};

/// The address and the keys of a session's datagrams.
struct SessionAddress {
  Address server;
  std::uint64_t session = 0;
  SessionKeys keys;
};

class Transport {
 public:
  enum class Arrival { nothing, reply, goodbye };

  /// `parameters`: as granted. `rotation`: orientation and torque travel too. `port`: connected to
  /// `to.server`; null opens a UDP port there. `scale`: of a position deadband. If the path does
  /// not allow such long datagrams, they have fewer samples. Throws SessionError.
  Transport(const SessionAddress& to, const SessionParameters& parameters, bool rotation,
            std::unique_ptr<DatagramPort> port = nullptr, const PositionScale& scale = {});
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  /// Continues with another session, of the same address family, through the same port. Packet
  /// numbers restart, and datagrams of the old session are ignored. Returns false if the system has
  /// no route there or does not have the cipher suite; then the old session stays.
  bool resume(const SessionAddress& to) noexcept;

  /// The port of the datagrams: its descriptor to wait on, and whether it needs the time.
  DatagramPort& port() noexcept { return *port_; }
  const DatagramPort& port() const noexcept { return *port_; }

  /// Call it with every sample. Sends the datagram that is due with it, with the report and the
  /// lead of a hand that leads a robot. Returns false if none is due.
  bool send(const Sample& sample, const std::optional<HandReport>& report = {},
            const std::optional<Lead>& lead = {}) noexcept;

  /// Takes the next valid datagram that has arrived. Invalid ones are counted and skipped, up to
  /// DatagramPort::kBurst of them, so that a flood costs the loop no more. Fills `reply` or
  /// `reason`, as the result says.
  Arrival receive(Reply& reply, GoodbyeReason& reason) noexcept {
    int left = DatagramPort::kBurst;
    return receive(reply, reason, left);
  }
  /// As above, but looks at no more than `left` datagrams, and takes those that it looked at off
  /// it.
  Arrival receive(Reply& reply, GoodbyeReason& reason, int& left) noexcept;

  /// An observer's view in the last reply; null: it had none. Valid until the next receive().
  const SceneView* view() const { return datagrams_.view(); }

  /// Tells the server that this client leaves. Sends it three times, because no answer comes, and
  /// before the datagrams that the port holds back, because the program may end before they leave.
  void goodbye() noexcept;

  TransportStatistics statistics() const {
    return {port_->statistics(), datagrams_.dropped(), datagrams_.shortened(),
            datagrams_.slowest_pace()};
  }

 private:
  void look_at_lengths() noexcept;

  DatagramSession datagrams_;
  std::unique_ptr<DatagramPort> port_;
  std::uint64_t too_long_ = 0;  // of the port's statistics, at the last call
};

}  // namespace feltwire

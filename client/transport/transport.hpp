#pragma once
// The datagrams of one session: samples out, replies in. Never blocks, allocates or throws once it
// stands.

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

  /// `parameters` as granted; `rotation`: orientation and torque travel too. `port`: connected to
  /// `to.server`; null opens a UDP port there. Where the path takes no datagrams as long, they
  /// carry fewer samples. `scale`: of a position deadband. Throws SessionError.
  Transport(const SessionAddress& to, const SessionParameters& parameters, bool rotation,
            std::unique_ptr<DatagramPort> port = nullptr, const PositionScale& scale = {});
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  /// Goes on with another session, of the same address family, through the same port: numbers begin
  /// anew, what was on its way is no longer listened to. False when the system has no way there or
  /// cannot do its cipher suite; then the old session stays.
  bool resume(const SessionAddress& to) noexcept;

  /// How its datagrams travel: what to wait on, when to pass() the time.
  DatagramPort& port() noexcept { return *port_; }
  const DatagramPort& port() const noexcept { return *port_; }

  /// To be given every sample: sends the datagram that is due with it. False when none is.
  bool send(const Sample& sample) noexcept;

  /// Takes the next datagram that has arrived and is good; bad ones are counted and skipped, up to
  /// DatagramPort::kBurst of them, so that a flood costs the loop no more than that. `reply` or
  /// `reason` is filled, as the result says.
  Arrival receive(Reply& reply, GoodbyeReason& reason) noexcept;

  /// The view in the last reply received, for an observer; null: it had none. Valid until the next
  /// receive().
  const SceneView* view() const { return datagrams_.view(); }

  /// Tells the server that this client leaves; three times, as no answer comes, and past the
  /// datagrams that the port holds back, as the program may end before they leave.
  void goodbye() noexcept;

  TransportStatistics statistics() const { return {port_->statistics(), datagrams_.dropped()}; }

 private:
  void look_at_lengths() noexcept;

  DatagramSession datagrams_;
  std::unique_ptr<DatagramPort> port_;
  std::uint64_t too_long_ = 0;  // of the port's statistics, when it was last looked at
};

}  // namespace feltwire

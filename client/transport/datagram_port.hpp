#pragma once
// The port for a session's datagrams: a UDP socket, or a layer in front of one, such as an emulated
// link.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "client/transport/control_client.hpp"
#include "protocol/session/client_change.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct PortStatistics {
  std::uint64_t sent = 0;  // datagrams that the system took
  std::uint64_t send_failed =
      0;  // not accepted by the system: buffer full, peer's port closed, no route
  std::uint64_t too_long = 0;  // longer than the path to the server allows
  std::uint64_t rerouted = 0;  // times that the port looked for another way to the server
  std::uint64_t received = 0;  // datagrams, before any check
};

/// A single thread uses it. Only report() and refuses_link() may block, allocate or throw.
class DatagramPort {
 public:
  /// The largest number of datagrams that one call takes from the system, so that a flood costs no
  /// more.
  static constexpr int kBurst = 64;

  virtual ~DatagramPort() = default;

  /// From now on sends to this server and receives only from it. The address family must be the
  /// same. Returns false if the system has no route there; then nothing has changed.
  virtual bool connect(const Address& server) noexcept = 0;
  /// Lets the system choose again its address for the server. Returns false if there is none now.
  virtual bool reroute() noexcept = 0;

  /// Sends a datagram. One that the system refuses is counted and lost, as any datagram may be.
  virtual void send(Bytes datagram) noexcept = 0;
  /// Sends a datagram at once, before those that this port holds back.
  virtual void send_now(Bytes datagram) noexcept { send(datagram); }
  /// The next datagram that has arrived. Its bytes stay until the next call.
  virtual std::optional<Bytes> receive() noexcept = 0;

  /// Whether this port holds datagrams back; then it needs the time by pass().
  virtual bool delays() const noexcept { return false; }
  /// Sets the time, for this and the following calls. Datagrams that are due leave, and arrived
  /// ones enter.
  virtual void pass(Nanoseconds /*now*/) noexcept {}
  /// The time at which the next datagram is due. Call pass() and receive() then.
  virtual std::optional<Nanoseconds> next_due() const noexcept { return std::nullopt; }

  /// Whether this port emulates a link that can be changed.
  virtual bool emulates() const noexcept { return false; }
  /// The reason why its link cannot be set to this one, with the remedy; empty if it can. Any
  /// thread may ask.
  virtual std::optional<std::string> refuses_link(const LinkQuality& /*link*/) const {
    return "it emulates no link: start the client with --link";
  }
  /// Datagrams that enter from now on meet this link. Precondition: refuses_link() refuses nothing.
  virtual void set_link(const LinkQuality& /*link*/) noexcept {}

  /// Readable if there may be a datagram to receive.
  virtual int descriptor() const noexcept = 0;
  virtual PortStatistics statistics() const noexcept = 0;

  /// JSON for the report of a run, beside the statistics; empty: nothing to add. The report takes
  /// other text, and the message of an exception, as a string. May allocate.
  virtual std::string report() const { return {}; }
};

/// A UDP socket. Datagrams are marked with `dscp` (protocol/net/udp_socket.hpp) and never
/// fragmented. If sending fails because the chosen local address is gone (another network, another
/// cell), it chooses another one. Throws SessionError.
std::unique_ptr<DatagramPort> open_udp_port(const Address& server, int dscp = 0);

}  // namespace feltwire

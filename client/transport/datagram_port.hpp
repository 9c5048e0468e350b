#pragma once
// How the datagrams of a session travel: a UDP socket, or something that stands before one, such as
// an emulated link.

#include <cstdint>
#include <memory>
#include <optional>
#include <string>

#include "client/transport/control_client.hpp"
#include "protocol/wire/datagram.hpp"

namespace feltwire {

struct PortStatistics {
  std::uint64_t sent = 0;         // datagrams that the system took
  std::uint64_t send_failed = 0;  // the system took none: buffer full, peer's port closed, no route
  std::uint64_t too_long = 0;     // longer than the path to the server takes
  std::uint64_t rerouted = 0;     // times that another way to the server was looked for
  std::uint64_t received = 0;     // datagrams, before any check
};

/// One thread uses it. No call but report() blocks, allocates or throws.
class DatagramPort {
 public:
  /// Datagrams that one call takes from the system at most, so that a flood costs no more than
  /// that.
  static constexpr int kBurst = 64;

  virtual ~DatagramPort() = default;

  /// Sends to this server from now on, of the same address family, and receives from it alone.
  /// False when the system has no way there; then nothing has changed.
  virtual bool connect(const Address& server) noexcept = 0;
  /// Has the system choose anew by which of its addresses the server is reached. False when there
  /// is none now.
  virtual bool reroute() noexcept = 0;

  /// Sends a datagram. What the system refuses is counted, and lost like any datagram may be.
  virtual void send(Bytes datagram) noexcept = 0;
  /// Sends a datagram past all that this port holds back.
  virtual void send_now(Bytes datagram) noexcept { send(datagram); }
  /// The next datagram that has come; its bytes stay until the next call.
  virtual std::optional<Bytes> receive() noexcept = 0;

  /// Whether datagrams are held back here: then pass() must be told the time.
  virtual bool delays() const noexcept { return false; }
  /// It is `now`, for this and the calls that follow: what is due leaves, what has come enters.
  virtual void pass(Nanoseconds /*now*/) noexcept {}
  /// When a datagram is due next: pass() and receive() are to be called then.
  virtual std::optional<Nanoseconds> next_due() const noexcept { return std::nullopt; }

  /// Readable when something may be received.
  virtual int descriptor() const noexcept = 0;
  virtual PortStatistics statistics() const noexcept = 0;

  /// JSON for the report of a run, beside the statistics; empty: there is nothing more to say.
  /// Other text stands in the report as a string, and so does what it throws. May allocate.
  virtual std::string report() const { return {}; }
};

/// A UDP socket. Datagrams are marked with `dscp` (protocol/net/udp_socket.hpp) and never cut into
/// fragments. Where sending fails because the address that the system chose is gone (another
/// network, another cell), it chooses another one. Throws SessionError.
std::unique_ptr<DatagramPort> open_udp_port(const Address& server, int dscp = 0);

}  // namespace feltwire

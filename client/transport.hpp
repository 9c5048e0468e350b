#pragma once
// The datagrams of one session: samples out, replies in. Never blocks, allocates or throws once it
// stands.

#include <array>
#include <cstdint>

#include "client/control_client.hpp"
#include "protocol/codec.hpp"
#include "protocol/sequence.hpp"

namespace feltwire {

struct TransportStatistics {
  std::uint64_t sent = 0;         // datagrams
  std::uint64_t send_failed = 0;  // the system took none: buffer full, peer's port closed, no route
  std::uint64_t received = 0;     // datagrams, before any check
  std::array<std::uint64_t, kDropReasons> dropped{};
};

class Transport {
 public:
  enum class Arrival { nothing, reply, goodbye };

  /// Opens a UDP socket to the session's scene. `redundancy` is k; `rotation`: orientation and
  /// torque travel too. Throws SessionError.
  Transport(const Address& server, std::uint64_t session, int redundancy, bool rotation);
  ~Transport();
  Transport(const Transport&) = delete;
  Transport& operator=(const Transport&) = delete;

  /// To wait for replies on.
  int descriptor() const { return socket_; }

  /// Sends a sample, and the k before it once more.
  void send(const Sample& sample) noexcept;

  /// Takes the next datagram that has arrived and is good; bad ones are counted and skipped, up to
  /// kBurst of them, so that a flood costs the loop no more than that. `reply` or `reason` is
  /// filled, as the result says.
  Arrival receive(Reply& reply, GoodbyeReason& reason) noexcept;
  static constexpr int kBurst = 64;

  /// Tells the server that this client leaves; three times, as no answer comes.
  void goodbye() noexcept;

  const TransportStatistics& statistics() const { return statistics_; }

 private:
  void transmit(Bytes datagram) noexcept;

  int socket_ = -1;
  std::uint64_t session_;
  int kept_;  // samples in a datagram
  Encoder encoder_;
  SampleBatch batch_;
  std::uint64_t packet_number_ = 0;
  PacketWindow seen_;
  std::array<std::uint8_t, kMaxDatagram + 1> buffer_;  // one more: what is too long shows
  TransportStatistics statistics_;
};

}  // namespace feltwire

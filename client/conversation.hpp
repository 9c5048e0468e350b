#pragma once
// The datagrams of one session as bytes: samples become datagrams, datagrams become replies. No
// socket, no clock.

#include <array>
#include <cstdint>

#include "protocol/codec.hpp"
#include "protocol/sequence.hpp"

namespace feltwire {

class Conversation {
 public:
  enum class Arrival { dropped, reply, goodbye };

  /// `redundancy` is k; `rotation`: orientation and torque travel too. Takes all its memory here.
  Conversation(std::uint64_t session, int redundancy, bool rotation);

  /// Goes on with another session: numbers begin anew, and what still comes of the old one is
  /// dropped.
  void resume(std::uint64_t session) noexcept;

  /// The datagram of a sample, and of the k before it once more. The bytes live until the next call
  /// of pack() or goodbye().
  Bytes pack(const Sample& sample) noexcept;
  Bytes goodbye() noexcept;

  /// From now on one sample less in a datagram, until the next session: the path takes no longer
  /// ones. False when one alone is left.
  bool carry_fewer() noexcept;

  /// Reads a datagram, all checks of PROTOCOL.md in their order; what fails one is counted. Fills
  /// `reply` or `reason`, as the result says.
  Arrival take(Bytes datagram, Reply& reply, GoodbyeReason& reason) noexcept;

  const std::array<std::uint64_t, kDropReasons>& dropped() const { return dropped_; }

 private:
  std::uint64_t session_;
  int kept_;     // samples in a datagram
  int carried_;  // of these, what the path takes
  Encoder encoder_;
  SampleBatch batch_;
  std::uint64_t packet_number_ = 0;
  PacketWindow seen_;
  std::array<std::uint64_t, kDropReasons> dropped_{};
};

}  // namespace feltwire

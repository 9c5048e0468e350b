#pragma once
// The datagrams of a robot's session as bytes: states out, targets in. No socket, no clock.

#include <array>
#include <cstdint>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/seal.hpp"

namespace feltwire {

class RobotDatagrams {
 public:
  enum class Arrival { dropped, target, goodbye };

  /// `keys`: of this session alone. Only this constructor allocates.
  RobotDatagrams(std::uint64_t session, const SessionKeys& keys);

  /// The bytes live until the next call of pack() or goodbye().
  Bytes pack(const RobotState& state) noexcept;
  Bytes goodbye() noexcept;

  /// Reads a datagram, with all checks of PROTOCOL.md in their order, and counts the dropped ones.
  /// Fills `target` or `reason`, as the result says.
  Arrival take(Bytes datagram, RobotTarget& target, GoodbyeReason& reason) noexcept;

  const std::array<std::uint64_t, kDropReasons>& dropped() const { return dropped_; }

 private:
  std::uint64_t session_;
  Encoder encoder_;
  Sealer sealer_;  // of datagrams to the server
  Opener opener_;  // of datagrams from it
  DatagramBuffer sealed_, opened_;
  std::array<std::uint64_t, kDropReasons> dropped_{};
};

}  // namespace feltwire

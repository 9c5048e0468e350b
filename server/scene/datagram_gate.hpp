#pragma once
// The checks of a received datagram, in the order of PROTOCOL.md.

#include <array>
#include <cstdint>

#include "protocol/wire/codec.hpp"
#include "protocol/wire/datagram.hpp"
#include "protocol/wire/guard.hpp"
#include "protocol/wire/seal.hpp"
#include "server/scene/fair_share.hpp"
#include "server/scene/session_ids.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

struct DatagramCounters {
  std::uint64_t datagrams = 0;      // received
  std::uint64_t late_goodbyes = 0;  // of these, under the number of a session that has just ended
  // Drops by rate of sessions that are above their share of the thread.
  std::uint64_t shed = 0;
  std::array<std::uint64_t, kDropReasons> drops{};
};

/// A datagram that its session sent and may send now.
struct Admitted {
  SessionSlot* session = nullptr;  // null: the datagram was dropped
  DatagramKind kind = DatagramKind::samples;
  bool newest = false;  // of its session
  Bytes payload;        // valid until the next datagram
};

/// The first check that fails drops the datagram and counts the reason. Nothing here allocates.
class DatagramGate {
 public:
  /// Both must outlive this.
  DatagramGate(SessionIds& ids, FairShare& share) : ids_(ids), share_(share) {}

  /// The checks `size` to `rate`: header, session, replay window, seal, rate, fair share.
  Admitted admit(Bytes datagram, Nanoseconds now) noexcept;

  /// The checks `malformed` to `not_finite`: reads the payload into a SampleBatch, a RobotState or
  /// a GoodbyeReason. False: it was dropped.
  template <class Value>
  bool read(Bytes payload, Value& value) noexcept {
    return passes(decode(payload, value));
  }

  /// The last check, `stale`, is that of the session or the robot's link. Counts its reason, or any
  /// other; false unless it is `none`.
  bool passes(DropReason reason) noexcept {
    if (reason == DropReason::none) return true;
    ++counters_.drops[static_cast<std::size_t>(reason)];
    return false;
  }

  const DatagramCounters& counters() const noexcept { return counters_; }

 private:
  void count_unknown(const Header& header) noexcept;
  bool is_within_rate(SessionSlot& slot, Nanoseconds now) noexcept;

  SessionIds& ids_;
  FairShare& share_;
  DatagramBuffer opened_;  // the present datagram
  DatagramCounters counters_;
};

}  // namespace feltwire

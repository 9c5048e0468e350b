#include "server/scene/datagram_gate.hpp"

#include "protocol/session/role.hpp"

namespace feltwire {
namespace {

constexpr unsigned kReceived =
    set_of({DatagramKind::samples, DatagramKind::goodbye, DatagramKind::follower_state});

/// Checks that a role may send this kind of datagram: a robot (Role::follower) sends its states,
/// all other roles send samples, and each role may send a goodbye.
bool may_send(Role role, DatagramKind kind) noexcept {
  return kind == DatagramKind::goodbye ||
         (kind == DatagramKind::follower_state) == (role == Role::follower);
}

}  // namespace

Admitted DatagramGate::admit(Bytes datagram, Nanoseconds now) noexcept {
  ++counters_.datagrams;
  share_.take_up();

  // Checks 1 to 5 of PROTOCOL.md: size, magic, version, kind, reserved.
  const Guarded guarded = guard(datagram, kReceived);
  if (!passes(guarded.drop)) return {};
  const Header& header = guarded.header;

  // Check 6: session.
  SessionSlot* const slot = ids_.find(header.session);
  if (slot == nullptr) {
    count_unknown(header);
    return {};
  }

  // Checks 7 and 8: packet_number, sealed.
  const Opened opened = slot->opener.open(header, datagram, opened_);
  if (opened.drop == DropReason::packet_number) slot->session.count_duplicate();
  if (!passes(opened.drop)) return {};

  // The seal proves who sent the datagram, so charge its computing time to that session.
  share_.attribute_to(slot->share);
  if (!may_send(slot->role, header.kind)) {
    passes(DropReason::kind);
    return {};
  }

  // Check 9: rate.
  if (header.kind != DatagramKind::goodbye && !is_within_rate(*slot, now)) return {};

  return {.session = slot,
          .kind = header.kind,
          .newest = header.packet_number == slot->opener.highest(),
          .payload = opened.payload};
}

/// Counts a datagram of a session that does not exist. A client repeats its goodbye, because a
/// datagram may be lost. So a goodbye of a session that has just ended is no error.
void DatagramGate::count_unknown(const Header& header) noexcept {
  if (header.kind == DatagramKind::goodbye && ids_.has_just_ended(header.session))
    ++counters_.late_goodbyes;
  else
    passes(DropReason::session);
}

bool DatagramGate::is_within_rate(SessionSlot& slot, Nanoseconds now) noexcept {
  if (!slot.rate.admit(now)) return passes(DropReason::rate);
  if (share_.admit(slot.share)) [[likely]]
    return true;
  ++counters_.shed;
  return passes(DropReason::rate);
}

}  // namespace feltwire

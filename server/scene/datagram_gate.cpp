#include "server/scene/datagram_gate.hpp"

#include "protocol/session/role.hpp"

namespace feltwire {
namespace {

constexpr unsigned kReceived =
    set_of({DatagramKind::samples, DatagramKind::goodbye, DatagramKind::follower_state});

/// Robots send states and all others samples; any session may say goodbye.
bool may_send(Role role, DatagramKind kind) noexcept {
  return kind == DatagramKind::goodbye ||
         (kind == DatagramKind::follower_state) == (role == Role::follower);
}

}  // namespace

Admitted DatagramGate::admit(Bytes datagram, Nanoseconds now) noexcept {
  ++counters_.datagrams;
  share_.take_up();

  // 1 to 5: size, magic, version, kind, reserved.
  const Guarded guarded = guard(datagram, kReceived);
  if (!passes(guarded.drop)) return {};
  const Header& header = guarded.header;

  // 6: session.
  SessionSlot* const slot = ids_.find(header.session);
  if (slot == nullptr) {
    count_unknown(header);
    return {};
  }

  // 7 and 8: packet_number, sealed.
  const Opened opened = slot->opener.open(header, datagram, opened_);
  if (opened.drop == DropReason::packet_number) slot->session.count_duplicate();
  if (!passes(opened.drop)) return {};

  // The seal proves the sender, so its session pays for the datagram from here on.
  share_.attribute_to(slot->share);
  if (!may_send(slot->role, header.kind)) {
    passes(DropReason::kind);
    return {};
  }

  // 9: rate.
  if (header.kind != DatagramKind::goodbye && !is_within_rate(*slot, now)) return {};

  return {.session = slot,
          .kind = header.kind,
          .newest = header.packet_number == slot->opener.highest(),
          .payload = opened.payload};
}

/// A client sends its goodbye more than once, because one may be lost: a repeated goodbye is no
/// fault.
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

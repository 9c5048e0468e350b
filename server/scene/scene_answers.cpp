// From the payload of an accepted datagram to its answer.

#include "server/scene/session_slot.hpp"

namespace feltwire {

Bytes SceneSessions::receive_samples(SessionSlot& slot, Bytes payload, const Origin& origin,
                                     DatagramBuffer& out) noexcept {
  const Bytes answer = answer_samples(slot, payload, origin);
  return answer.empty() ? answer : slot.sealer.seal(DatagramKind::reply, slot.id, answer, out);
}

/// The payload of the reply; empty: there is none.
Bytes SceneSessions::answer_samples(SessionSlot& slot, Bytes payload,
                                    const Origin& origin) noexcept {
  if (const DropReason wrong = decode(payload, batch_); wrong != DropReason::none)
    return drop(wrong);
  const std::uint64_t before = slot.session.counters().samples;
  const Taken taken = slot.session.take(batch_, origin.now);
  if (taken.drop != DropReason::none) return drop(taken.drop);
  slot.rate.count(slot.session.counters().samples - before);
  slot.last_heard = origin.now;
  // Whoever holds a datagram back and sends it on from elsewhere draws no goodbye there.
  if (origin.newest) slot.peer = origin.from;
  const Bytes answer = taken.withheld            ? Bytes{}
                       : slot.session.observes() ? show(slot, taken.reply)
                                                 : encoder_.reply(taken.reply);
  if (log_ != nullptr)
    log({.kind = EventKind::samples,
         .outcome = taken.withheld ? EventOutcome::withheld : EventOutcome::answered,
         .hand = slot.number,
         .time = origin.now,
         .digest = taken.withheld ? 0 : digest(answer),
         .payload = payload});
  return answer;
}

/// An observer's reply, with what there is to see.
Bytes SceneSessions::show(SessionSlot& slot, const Reply& reply) noexcept {
  const SessionParameters& parameters = slot.session.parameters();
  const double between = parameters.packet_interval * parameters.servo_period;
  slot.observer_view.show(hands_, world_.get(), view_room(between), view_);
  return encoder_.reply(reply, &view_);
}

Bytes SceneSessions::replay_samples(std::uint64_t id, Bytes payload, Nanoseconds now) noexcept {
  SessionSlot** slot = by_id_.find(id);
  if (slot == nullptr) return {};
  return answer_samples(**slot, payload, {Peer{}, true, now});
}

}  // namespace feltwire

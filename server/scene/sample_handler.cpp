#include "server/scene/sample_handler.hpp"

#include <algorithm>

#include "protocol/session/role.hpp"

namespace feltwire {
namespace {

constexpr std::size_t kReplyBytes = 288;  // [bytes] size of an observer's reply without the view

/// Stores the time of a datagram and, if it is the newest of its session, the sender's address.
void hear(SessionSlot& slot, const Origin& origin) noexcept {
  slot.last_heard = origin.now;
  // An attacker may delay a datagram and send it from another address. It is then not the newest,
  // and the session's goodbye does not go to that address.
  if (origin.newest) slot.peer = origin.from;
}

}  // namespace

Bytes SampleHandler::answer(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept {
  // Checks 10 to 13 of PROTOCOL.md: malformed, count, order, not_finite.
  if (!gate_.read(payload, batch_)) return {};
  if (!seats_.empty()) slot.session.reach_through_arm(seats_.leads_arm(slot, batch_));

  // Compute the contacts, limit the force and make the reply. Includes check 14: stale.
  const std::uint64_t before = slot.session.counters().samples;
  BatchResult taken = slot.session.take(batch_, origin.now);
  if (!gate_.passes(taken.drop)) return {};
  slot.rate.count(slot.session.counters().samples - before);

  if (slot.waits_for_client()) [[unlikely]] {
    client_changes_.hear(slot, batch_.report);
    if (slot.waits_for_client()) taken.reply.change = slot.asked->change;
  }
  hear(slot, origin);
  taken.reply.pace = slot.pace.intervals;
  if (!seats_.empty() && batch_.lead && covers(slot.role, Role::operator_))
    taken.reply.remote = seats_.lead(slot, batch_, origin.now);

  const Bytes answer = taken.withheld            ? Bytes{}
                       : slot.session.observes() ? reply_to_observer(slot, taken.reply, origin.now)
                                                 : reply_to_hand(slot, taken.reply, origin.now);
  if (log_.is_on())
    log_.put({.kind = EventKind::samples,
              .outcome = taken.withheld ? EventOutcome::withheld : EventOutcome::answered,
              .hand = slot.number,
              .time = origin.now,
              .digest = taken.withheld ? 0 : digest(answer),
              .payload = payload});
  return answer;
}

void SampleHandler::take_state(SessionSlot& robot, Bytes payload, const Origin& origin) noexcept {
  if (!gate_.read(payload, state_)) return;
  if (!seats_.follow(robot, state_, origin.now)) {
    robot.session.count_duplicate();
    gate_.passes(DropReason::stale);
    return;
  }
  robot.rate.count(1);
  hear(robot, origin);
  log_.put({.kind = EventKind::samples,
            .outcome = EventOutcome::withheld,
            .hand = robot.number,
            .time = origin.now,
            .digest = 0,
            .payload = payload});
}

/// Encodes the reply. If it is too long for the path to the client, shortens the reply's model.
Bytes SampleHandler::reply_to_hand(SessionSlot& slot, Reply& reply, Nanoseconds now) noexcept {
  Bytes bytes = encoder_.reply(reply);
  const std::size_t room = paths_.room(slot, now);
  if (room == kMaxPayload) [[likely]]
    return bytes;
  while (bytes.size() > room && slot.session.shorten(reply, bytes.size() - room))
    bytes = encoder_.reply(reply, nullptr, true);
  return bytes;
}

/// Encodes the reply with the next part of the view of the scene.
Bytes SampleHandler::reply_to_observer(SessionSlot& slot, const Reply& reply,
                                       Nanoseconds now) noexcept {
  const SessionParameters& parameters = slot.session.parameters();
  const std::size_t whole = view_room(parameters.packet_interval * parameters.servo_period);
  const std::size_t path = paths_.room(slot, now);
  const std::size_t room = std::min(whole, path - std::min(path, kReplyBytes));
  return encoder_.reply(reply, &views_.next(slot, room, now), room < whole);
}

}  // namespace feltwire

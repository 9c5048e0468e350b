// Answers the payload of an accepted datagram.

#include "server/scene/scene_sessions.hpp"

namespace feltwire {

Bytes SceneSessions::receive_samples(SessionSlot& slot, Bytes payload, const Origin& origin,
                                     DatagramBuffer& out) noexcept {
  const Bytes answer = answer_samples(slot, payload, origin);
  return answer.empty() ? answer : slot.sealer.seal(DatagramKind::reply, slot.id, answer, out);
}

/// Returns the payload of the reply; empty: there is none.
Bytes SceneSessions::answer_samples(SessionSlot& slot, Bytes payload,
                                    const Origin& origin) noexcept {
  if (const DropReason wrong = decode(payload, batch_); wrong != DropReason::none)
    return drop(wrong);
  if (!seats_.empty()) slot.session.reach_through_arm(leads_arm(slot));
  const std::uint64_t before = slot.session.counters().samples;
  BatchResult taken = slot.session.take(batch_, origin.now);
  if (taken.drop != DropReason::none) return drop(taken.drop);
  slot.rate.count(slot.session.counters().samples - before);
  if (slot.waits_for_client()) [[unlikely]] {
    hear_answer(slot);
    if (slot.waits_for_client()) taken.reply.change = slot.asked->change;
  }
  slot.last_heard = origin.now;
  // If somebody delays a datagram and sends it from elsewhere, no goodbye goes to that address.
  if (origin.newest) slot.peer = origin.from;
  if (!seats_.empty() && batch_.lead && covers(slot.role, Role::operator_))
    taken.reply.remote = lead(slot, origin.now);
  const Bytes answer = taken.withheld            ? Bytes{}
                       : slot.session.observes() ? show(slot, taken.reply, origin.now)
                                                 : fitted(slot, taken.reply, origin.now);
  if (log_.is_on())
    log_.put({.kind = EventKind::samples,
              .outcome = taken.withheld ? EventOutcome::withheld : EventOutcome::answered,
              .hand = slot.number,
              .time = origin.now,
              .digest = taken.withheld ? 0 : digest(answer),
              .payload = payload});
  return answer;
}

/// An observer's reply, with the view of the scene.
Bytes SceneSessions::show(SessionSlot& slot, const Reply& reply, Nanoseconds now) noexcept {
  const SessionParameters& parameters = slot.session.parameters();
  const double between = parameters.packet_interval * parameters.servo_period;
  std::size_t room = room_of(slot, view_room(between), now);
  const bool is_short = room < view_room(between);
  const std::size_t hand_size =
      SceneView::kHandSize + (slot.figures ? SceneView::kFiguresSize + kFiguresOverhead : 0);
  // If the path has no room for a robot and a hand together, they take turns.
  const bool both = room >= kSeenRobotRoom + hand_size;
  view_.robot.reset();
  if (both || slot.session.counters().replies % 2 == 0) view_.robot = next_robot(slot, now);
  if (view_.robot) room -= std::min(room, kSeenRobotRoom);
  if (slot.figures && room >= hand_size) {
    slot.observer_view.show(hands_, world_.get(), room - kFiguresOverhead, view_,
                            SceneView::kHandSize + SceneView::kFiguresSize);
    add_figures(view_, now);
  } else {
    slot.observer_view.show(hands_, world_.get(), room, view_);
  }
  return encoder_.reply(reply, &view_, is_short);
}

Bytes SceneSessions::replay_samples(std::uint64_t id, Bytes payload, Nanoseconds now) noexcept {
  SessionSlot** slot = by_id_.find(id);
  if (slot == nullptr) return {};
  const Origin origin{Peer{}, true, now};
  if ((*slot)->role != Role::follower) return answer_samples(**slot, payload, origin);
  receive_state(**slot, payload, origin);
  return {};
}

/// Takes the client's answer to the change that was asked of it, if this datagram has one.
void SceneSessions::hear_answer(SessionSlot& slot) noexcept {
  AskedChange& asked = *slot.asked;
  if (!batch_.report || batch_.report->change != asked.change.number) return;
  asked.told = false;
  has_answers_ = true;
  const bool refused = batch_.report->change_refused;
  if (refused && asked.unheard_law) {
    // The client may or may not have taken the law that was asked for before this one. It had the
    // session's law, so ask it to take that law again.
    asked.change = {.number = number_after(asked.change.number),
                    .law = law_of(slot.session.parameters()),
                    .link = {}};
    asked.unheard_law = false;
    asked.returns = true;
    return;
  }
  asked.answer = refused ? ChangeAnswer::refused : ChangeAnswer::taken;
  if (!refused && asked.change.law && !asked.returns) slot.session.put_law(asked.parameters);
}

std::vector<std::string> SceneSessions::answers() {
  std::vector<std::string> lines;
  has_answers_ = false;
  for (const auto& slot : slots_) {
    if (!slot->asked || slot->asked->told) continue;
    slot->asked->told = true;
    const std::string who =
        "session " + std::to_string(slot->number) + " (" + slot->session.client() + "): its client";
    if (!slot->asked->returns)
      lines.push_back(who + " has " + std::string(name(slot->asked->answer)) +
                      " the change: " + slot->asked->what);
    else if (slot->waits_for_client())
      lines.push_back(who + " has refused the change: " + slot->asked->what +
                      "; it is asked to return to the law of its session");
    else
      lines.push_back(who + " has " + std::string(name(slot->asked->answer)) +
                      " the return to the law of its session");
  }
  return lines;
}

}  // namespace feltwire

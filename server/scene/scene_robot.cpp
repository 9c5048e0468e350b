// The robot of a scene: who sits on its seat, what it says, and where it shall be.

#include "server/scene/session_slot.hpp"

namespace feltwire {

/// Why this one cannot sit on the robot's seat; nothing: it is no robot, or it can.
std::optional<control::Refused> SceneSessions::refuse_robot(
    const control::JoinRequest& request) const {
  if (request.role != Role::follower) return std::nullopt;
  const std::string scene = "scene '" + scene_->name() + "'";
  if (!link_)
    return control::Refused{control::RefusalCode::not_supported,
                            scene + " has no seat for a robot; give it a \"remote\""};
  if (link_->taken())
    return control::Refused{control::RefusalCode::full,
                            scene +
                                " has one seat for a robot, and a robot sits there; end its "
                                "session first"};
  const RemoteSeat& seat = *scene_->remote();
  if (!has_room(joined(seat.workspace, request.workspace), seat.wall_depth * seat.scale))
    return control::Refused{
        control::RefusalCode::bad_parameters,
        "the robot's own workspace and that of " + scene +
            " leave no place that is in both; widen one of them, or leave one out"};
  return std::nullopt;
}

/// The payload of a robot's state. The answer is the target that forward() sends.
void SceneSessions::receive_state(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept {
  if (const DropReason wrong = decode(payload, robot_state_); wrong != DropReason::none) {
    drop(wrong);
    return;
  }
  if (!link_->follow(robot_state_, origin.now)) {
    slot.session.count_duplicate();
    drop(DropReason::stale);
    return;
  }
  slot.rate.count(1);
  slot.last_heard = origin.now;
  if (origin.newest) slot.peer = origin.from;
  if (log_ != nullptr)
    log({.kind = EventKind::samples,
         .outcome = EventOutcome::withheld,
         .hand = slot.number,
         .time = origin.now,
         .digest = 0,
         .payload = payload});
}

Bytes SceneSessions::forward(Nanoseconds now, Peer& to, DatagramBuffer& out) noexcept {
  if (robot_ == nullptr || robot_->peer.length == 0 || !link_->target_due(now)) return {};
  to = robot_->peer;
  return robot_->sealer.seal(DatagramKind::follower_target, robot_->id,
                             encoder_.target(link_->target(now)), out);
}

}  // namespace feltwire

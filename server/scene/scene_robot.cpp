// The robots of a scene: their seats, their reported states, their targets and the hands that lead
// them.

#include <algorithm>

#include "server/scene/scene_sessions.hpp"

namespace feltwire {
namespace {

/// The numbers of arms of the world begin after this; sessions never reach it.
constexpr std::uint32_t kFirstArm = 0xFFFF0000;

/// "left, right"
std::string names_of(const std::vector<RemoteSeat>& seats) {
  std::string names;
  for (const RemoteSeat& seat : seats) names += (names.empty() ? "" : ", ") + seat.name;
  return names;
}

}  // namespace

std::vector<SceneSessions::Seat> SceneSessions::seats_of(const Scene& scene, World* world) const {
  std::vector<Seat> seats;
  for (const RemoteSeat& seat : scene.seats()) {
    Seat& made = seats.emplace_back(Seat{.link = TeleopLink(seat)});
    if (!seat.arm || world == nullptr) continue;
    made.arm.emplace(seat, *world);
    made.link.seat_robot(kFirstArm + static_cast<std::uint32_t>(seats.size()));
  }
  // A robot keeps its seat if the seats are the same.
  if (has_same_seats(scene))
    for (std::size_t i = 0; i < seats.size(); ++i) {
      if (seats[i].arm) continue;
      seats[i].robot = seats_[i].robot;
      seats[i].own = seats_[i].own;
      if (seats[i].robot != nullptr) seats[i].link.seat_robot(seats[i].robot->number, seats[i].own);
    }
  return seats;
}

std::string SceneSessions::seat_name(std::size_t seat) const {
  return seat < scene_->seats().size() ? scene_->seats()[seat].name : std::string();
}

/// Compares number, names, and who sits there: a robot or an arm of the world.
bool SceneSessions::has_same_seats(const Scene& scene) const noexcept {
  return seats_.size() == scene.seats().size() &&
         std::ranges::equal(scene_->seats(), scene.seats(),
                            [](const RemoteSeat& a, const RemoteSeat& b) {
                              return a.name == b.name && a.arm.has_value() == b.arm.has_value();
                            });
}

/// Null: there is none. An empty name means the seat of a scene with only one.
const RemoteSeat* SceneSessions::seat_named(const std::string& name) const noexcept {
  const std::vector<RemoteSeat>& seats = scene_->seats();
  if (name.empty()) return seats.size() == 1 ? &seats.front() : nullptr;
  const auto found = std::ranges::find(seats, name, &RemoteSeat::name);
  return found == seats.end() ? nullptr : &*found;
}

/// Why this client cannot sit on the seat that it asks for; nothing: it is no robot, or it can.
std::optional<control::Refused> SceneSessions::refuse_robot(
    const control::JoinRequest& request) const {
  if (request.role != Role::follower) return std::nullopt;
  const std::string scene = "scene '" + scene_->name() + "'";
  if (seats_.empty())
    return control::Refused{control::RefusalCode::not_supported,
                            scene + " has no seat for a robot; give it a \"remote\""};
  const RemoteSeat* const seat = seat_named(request.seat);
  if (seat == nullptr) {
    const std::string asked =
        request.seat.empty() ? " has several seats" : " has no seat '" + request.seat + "'";
    const std::string has = seats_.size() == 1 && scene_->seats().front().name.empty()
                                ? "; its only seat has no name: leave out --seat"
                                : "; choose with --seat: " + names_of(scene_->seats());
    return control::Refused{control::RefusalCode::bad_parameters, scene + asked + has};
  }
  if (seat->arm)
    return control::Refused{control::RefusalCode::full,
                            (seat->name.empty() ? "the seat" : "the seat '" + seat->name + "'") +
                                " of " + scene +
                                " is for the arm of the scene's own mjcf, which the server moves; "
                                "a robot needs a seat without \"arm\""};
  if (seats_[static_cast<std::size_t>(seat - scene_->seats().data())].link.taken())
    return control::Refused{control::RefusalCode::full,
                            (seat->name.empty() ? "the seat" : "the seat '" + seat->name + "'") +
                                " of " + scene +
                                " is taken: a robot sits there; end its session first"};
  if (!has_room(joined(seat->workspace, request.workspace), seat->wall_depth * seat->scale))
    return control::Refused{
        control::RefusalCode::bad_parameters,
        "the robot's own workspace and that of " + scene +
            " leave no place that is in both; widen one of them, or leave one out"};
  return std::nullopt;
}

/// Takes the payload of a robot's state. The answer is the target that forward() sends.
void SceneSessions::receive_state(SessionSlot& slot, Bytes payload, const Origin& origin) noexcept {
  if (const DropReason wrong = decode(payload, robot_state_); wrong != DropReason::none) {
    drop(wrong);
    return;
  }
  if (!seats_[slot.seat].link.follow(robot_state_, origin.now)) {
    slot.session.count_duplicate();
    drop(DropReason::stale);
    return;
  }
  slot.rate.count(1);
  slot.last_heard = origin.now;
  if (origin.newest) slot.peer = origin.from;
  if (log_.is_on())
    log_.put({.kind = EventKind::samples,
              .outcome = EventOutcome::withheld,
              .hand = slot.number,
              .time = origin.now,
              .digest = 0,
              .payload = payload});
}

/// Whether the hand that sent the batch moves an arm of the world, or wants to lead one.
bool SceneSessions::leads_arm(const SessionSlot& slot) const noexcept {
  if (!batch_.lead || !covers(slot.role, Role::operator_)) return false;
  const bool moves = seats_[slot.seat].link.engages(slot.number);
  const std::size_t seat = moves ? slot.seat : batch_.lead->seat;
  return seat < seats_.size() && seats_[seat].arm;
}

/// The hand leads the robot that it asks for. It keeps its present robot while it moves that robot.
/// For a seat that does not exist, the state is `disabled`.
Remote SceneSessions::lead(SessionSlot& slot, Nanoseconds now) noexcept {
  slot.leads = true;
  const std::uint8_t wanted = batch_.lead->seat;
  if (wanted != slot.seat && !seats_[slot.seat].link.engages(slot.number)) {
    seats_[slot.seat].link.leave(slot.number);
    if (wanted >= seats_.size()) {
      Remote none;
      none.seat = wanted;
      return none;
    }
    slot.seat = wanted;
  }
  TeleopLink& link = seats_[slot.seat].link;
  link.lead(slot.number, batch_, slot.session.parameters().servo_period, now, slot.lead_share);
  Remote reply = link.reply_for(slot.number, now);
  reply.seat = slot.seat;
  return reply;
}

std::optional<SeenRobot> SceneSessions::seen_robot(std::size_t seat,
                                                   Nanoseconds now) const noexcept {
  std::optional<SeenRobot> robot = seats_[seat].link.view(now);
  if (!robot) return robot;
  robot->seat = static_cast<std::uint8_t>(seat);
  unsigned all = 0;
  for (std::size_t i = 0; i < seats_.size(); ++i)
    if (seats_[i].link.visible()) all |= 1u << i;
  robot->seats = static_cast<std::uint8_t>(all);
  return robot;
}

/// Returns the next visible robot, in turn.
std::optional<SeenRobot> SceneSessions::next_robot(SessionSlot& observer,
                                                   Nanoseconds now) const noexcept {
  for (std::size_t i = 1; i <= seats_.size(); ++i) {
    const std::size_t seat = (observer.seen + i) % seats_.size();
    if (auto robot = seen_robot(seat, now)) {
      observer.seen = static_cast<std::uint8_t>(seat);
      return robot;
    }
  }
  return std::nullopt;
}

Bytes SceneSessions::forward(std::size_t seat, Nanoseconds now, Peer& to,
                             DatagramBuffer& out) noexcept {
  SessionSlot* const robot = seats_[seat].robot;
  if (robot == nullptr || robot->peer.length == 0 || !seats_[seat].link.target_due(now)) return {};
  to = robot->peer;
  return robot->sealer.seal(DatagramKind::follower_target, robot->id,
                            encoder_.target(seats_[seat].link.target(now)), out);
}

}  // namespace feltwire

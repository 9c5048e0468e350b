#include "server/scene/robot_seats.hpp"

#include <algorithm>

#include "core/teleoperation/workspace.hpp"
#include "protocol/session/role.hpp"

namespace feltwire {
namespace {

using control::RefusalCode;
using control::Refused;

/// The simulated arms of the scene have numbers above this. Sessions are numbered from 1, and there
/// are never so many.
constexpr std::uint32_t kFirstArm = 0xFFFF0000;

/// Returns the names in the form "left, right".
std::string names_of(const std::vector<RobotSeat>& seats) {
  std::string names;
  for (const RobotSeat& seat : seats) names += (names.empty() ? "" : ", ") + seat.link.seat().name;
  return names;
}

}  // namespace

std::vector<RobotSeat> RobotSeats::seats_of(const Scene& scene, World* world) const {
  std::vector<RobotSeat> seats;
  for (const RemoteSeat& seat : scene.seats()) {
    RobotSeat& made = seats.emplace_back(RobotSeat{.link = TeleopLink(seat)});
    if (!seat.arm || world == nullptr) continue;
    made.arm.emplace(seat, *world);
    made.link.seat_robot(kFirstArm + static_cast<std::uint32_t>(seats.size()));
  }
  if (is_same(scene))
    for (std::size_t i = 0; i < seats.size(); ++i) {
      if (seats[i].arm) continue;
      seats[i].robot = seats_[i].robot;
      seats[i].own = seats_[i].own;
      if (seats[i].robot != nullptr) seats[i].link.seat_robot(seats[i].robot->number, seats[i].own);
    }
  return seats;
}

bool RobotSeats::is_same(const Scene& scene) const noexcept {
  return std::ranges::equal(seats_, scene.seats(), [](const RobotSeat& a, const RemoteSeat& b) {
    return a.link.seat().name == b.name && a.link.seat().arm.has_value() == b.arm.has_value();
  });
}

std::string RobotSeats::name(std::size_t seat) const {
  return seat < seats_.size() ? seats_[seat].link.seat().name : std::string();
}

/// Returns the seat of this name, or null. An empty name means the only seat of a scene; if the
/// scene has several seats, the result is null.
const RobotSeat* RobotSeats::find(const std::string& name) const noexcept {
  if (name.empty()) return seats_.size() == 1 ? &seats_.front() : nullptr;
  const auto found = std::ranges::find_if(
      seats_, [&](const RobotSeat& seat) { return seat.link.seat().name == name; });
  return found == seats_.end() ? nullptr : &*found;
}

std::optional<Refused> RobotSeats::refuse(const control::JoinRequest& request,
                                          const std::string& scene_name) const {
  if (request.role != Role::follower) return std::nullopt;
  const std::string scene = "scene '" + scene_name + "'";
  if (seats_.empty())
    return Refused{RefusalCode::not_supported,
                   scene + " has no seat for a robot; give it a \"remote\""};
  const RobotSeat* const found = find(request.seat);
  if (found == nullptr) {
    const std::string asked =
        request.seat.empty() ? " has several seats" : " has no seat '" + request.seat + "'";
    const std::string has = seats_.size() == 1 && name(0).empty()
                                ? "; its only seat has no name: leave out --seat"
                                : "; choose with --seat: " + names_of(seats_);
    return Refused{RefusalCode::bad_parameters, scene + asked + has};
  }
  const RemoteSeat& seat = found->link.seat();
  const std::string the_seat = (seat.name.empty() ? "the seat" : "the seat '" + seat.name + "'");
  if (seat.arm)
    return Refused{RefusalCode::full,
                   the_seat + " of " + scene +
                       " is for the arm of the scene's own mjcf, which the server moves; "
                       "a robot needs a seat without \"arm\""};
  if (found->link.taken())
    return Refused{RefusalCode::full, the_seat + " of " + scene +
                                          " is taken: a robot sits there; end its session first"};
  if (!has_room(joined(seat.workspace, request.workspace), seat.wall_depth * seat.scale))
    return Refused{RefusalCode::bad_parameters,
                   "the robot's own workspace and that of " + scene +
                       " leave no place that is in both; widen one of them, or leave one out"};
  return std::nullopt;
}

const RemoteSeat& RobotSeats::seat_robot(SessionSlot& robot,
                                         const control::JoinRequest& request) noexcept {
  robot.seat = static_cast<std::uint8_t>(find(request.seat) - seats_.data());
  RobotSeat& seat = seats_[robot.seat];
  seat.robot = &robot;
  seat.own = request.workspace;
  seat.link.seat_robot(robot.number, seat.own);
  return seat.link.seat();
}

void RobotSeats::leave(const SessionSlot& slot) noexcept {
  if (slot.seat >= seats_.size()) return;
  RobotSeat& seat = seats_[slot.seat];
  seat.link.leave(slot.number);
  if (seat.robot == &slot) seat.robot = nullptr;
}

bool RobotSeats::leads_arm(const SessionSlot& hand, const SampleBatch& batch) const noexcept {
  if (!batch.lead || !covers(hand.role, Role::operator_)) return false;
  const bool moves = seats_[hand.seat].link.engages(hand.number);
  const std::size_t seat = moves ? hand.seat : batch.lead->seat;
  return seat < seats_.size() && seats_[seat].arm;
}

Remote RobotSeats::lead(SessionSlot& hand, const SampleBatch& batch, Nanoseconds now) noexcept {
  hand.leads = true;
  const std::uint8_t wanted = batch.lead->seat;
  if (wanted != hand.seat && !seats_[hand.seat].link.engages(hand.number)) {
    seats_[hand.seat].link.leave(hand.number);
    if (wanted >= seats_.size()) {
      Remote none;
      none.seat = wanted;
      return none;
    }
    hand.seat = wanted;
  }
  TeleopLink& link = seats_[hand.seat].link;
  link.lead(hand.number, batch, hand.session.parameters().servo_period, now, hand.lead_share);
  Remote reply = link.reply_for(hand.number, now);
  reply.seat = hand.seat;
  return reply;
}

std::optional<SeenRobot> RobotSeats::seen(std::size_t seat, Nanoseconds now) const noexcept {
  std::optional<SeenRobot> robot = seats_[seat].link.view(now);
  if (!robot) return robot;
  robot->seat = static_cast<std::uint8_t>(seat);
  unsigned all = 0;
  for (std::size_t i = 0; i < seats_.size(); ++i)
    if (seats_[i].link.visible()) all |= 1u << i;
  robot->seats = static_cast<std::uint8_t>(all);
  return robot;
}

std::optional<SeenRobot> RobotSeats::next_seen(SessionSlot& observer,
                                               Nanoseconds now) const noexcept {
  for (std::size_t i = 1; i <= seats_.size(); ++i) {
    const std::size_t seat = (observer.observer.seat + i) % seats_.size();
    if (auto robot = seen(seat, now)) {
      observer.observer.seat = static_cast<std::uint8_t>(seat);
      return robot;
    }
  }
  return std::nullopt;
}

Bytes RobotSeats::forward(std::size_t seat, Nanoseconds now, Peer& to,
                          DatagramBuffer& out) noexcept {
  SessionSlot* const robot = seats_[seat].robot;
  if (robot == nullptr || robot->peer.length == 0 || !seats_[seat].link.target_due(now)) return {};
  to = robot->peer;
  return robot->sealer.seal(DatagramKind::follower_target, robot->id,
                            encoder_.target(seats_[seat].link.target(now)), out);
}

}  // namespace feltwire

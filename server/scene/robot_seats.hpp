#pragma once
// The robots of a scene: their seats, their reported states, their targets, and the hands that lead
// them.

#include <cstdint>
#include <optional>
#include <span>
#include <string>
#include <vector>

#include "core/dynamics/world.hpp"
#include "core/scene/scene.hpp"
#include "protocol/wire/codec.hpp"
#include "protocol/wire/control.hpp"
#include "protocol/wire/scene_view.hpp"
#include "protocol/wire/seal.hpp"
#include "server/scene/robot_seat.hpp"
#include "server/scene/session_slot.hpp"

namespace feltwire {

class RobotSeats {
 public:
  /// The seats of another scene. Robots keep their seats if is_same(). `world`: of the scene; null:
  /// nothing moves. Allocates, and changes nothing here.
  std::vector<RobotSeat> seats_of(const Scene& scene, World* world) const;
  /// Whether a scene has the same seats, by number, names, and who sits there: a robot or an arm of
  /// the world.
  bool is_same(const Scene& scene) const noexcept;
  void take_over(std::vector<RobotSeat> seats) noexcept { seats_ = std::move(seats); }

  std::size_t size() const noexcept { return seats_.size(); }
  bool empty() const noexcept { return seats_.empty(); }
  std::span<RobotSeat> seats() noexcept { return seats_; }
  /// Empty: the only seat, or there is no such seat.
  std::string name(std::size_t seat) const;
  /// The state between the robot on a seat and its hand. Precondition: seat < size().
  LinkState state(std::size_t seat) const noexcept { return seats_[seat].link.state(); }

  /// Why this client cannot sit on the seat that it asks for; nothing: it is no robot, or it can.
  std::optional<control::Refused> refuse(const control::JoinRequest& request,
                                         const std::string& scene) const;
  /// A robot takes the seat that it asks for, whose description is the result. Precondition:
  /// refuse() has no reason.
  const RemoteSeat& seat_robot(SessionSlot& robot, const control::JoinRequest& request) noexcept;
  /// A robot, or a hand that may lead one, has left.
  void leave(const SessionSlot& slot) noexcept;

  /// The state of a robot; false: it is not newer than the one before.
  bool follow(const SessionSlot& robot, const RobotState& state, Nanoseconds now) noexcept {
    return seats_[robot.seat].link.follow(state, now);
  }
  /// Whether the hand that sent the batch moves an arm of the world, or wants to lead one.
  bool leads_arm(const SessionSlot& hand, const SampleBatch& batch) const noexcept;
  /// The hand leads the robot that the batch asks for. It keeps its present robot while it moves
  /// that robot. Returns the part of the reply; for a seat that does not exist, its state is
  /// `disabled`. Precondition: the batch has a lead.
  Remote lead(SessionSlot& hand, const SampleBatch& batch, Nanoseconds now) noexcept;
  bool moves_robot(const SessionSlot& hand) const noexcept {
    return hand.seat < seats_.size() && seats_[hand.seat].link.engages(hand.number);
  }

  /// The robot on a seat, for observers; empty: there is none, or it has sent nothing yet.
  /// Precondition: seat < size().
  std::optional<SeenRobot> seen(std::size_t seat, Nanoseconds now) const noexcept;
  /// The next visible robot for this observer, in turn.
  std::optional<SeenRobot> next_seen(SessionSlot& observer, Nanoseconds now) const noexcept;

  /// The newest target of the robot on a seat as a datagram, and its receiver; empty: none is due.
  /// Never allocates. Precondition: seat < size().
  Bytes forward(std::size_t seat, Nanoseconds now, Peer& to, DatagramBuffer& out) noexcept;

 private:
  const RobotSeat* find(const std::string& name) const noexcept;

  std::vector<RobotSeat> seats_;
  Encoder encoder_;
};

}  // namespace feltwire

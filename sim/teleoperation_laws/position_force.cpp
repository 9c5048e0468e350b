#include "sim/teleoperation_laws/position_force.hpp"

#include "core/base/numeric.hpp"

namespace feltwire::teleop {
namespace {

constexpr double kTouches = 0.1;  // [N] force above which the robot touches a surface

BoundingConfig config(const Plant& plant, std::string_view method) {
  BoundingConfig c;
  c.mode = method;
  c.period = plant.period;
  c.damping = Damping(plant.leader_damping);
  c.max_force = plant.leader_force;
  c.quantum = plant.leader_quantum;
  return c;
}

template <class Sample, class Force, class Message>
void say(const Sample& s, const Force& force, Message& out) {
  out.position = s.position;
  out.velocity = s.velocity;
  out.force = force;
}

}  // namespace

BoundedHand::BoundedHand(const Plant& plant, std::string_view method)
    : period_(plant.period), bound_(config(plant, method)) {}

Vec3 BoundedHand::step(const Vec3& hand, const Vec3& wanted) {
  BoundingStep step;
  step.displacement = moved(before_, hand);
  step.hold_time = period_;
  step.command.elastic = -wanted;
  return -bound_.step(step).rendered.elastic;
}

TwoPortHand::TwoPortHand(const Plant& plant)
    : period_(plant.period), bound_(plant.leader_damping, plant.period), remote_(RemoteTrust{}) {}

Vec3 TwoPortHand::step(const Vec3& hand, const Vec3& wanted, bool apart) {
  remote_.step(period_);
  const Vec3 force = bound_.step({.displacement = moved(before_, hand),
                                  .hold_time = period_,
                                  .command = -wanted,
                                  .remote = remote_.net()});
  if (held_.isZero(0.0) && apart) {
    bound_.begin_contact();
    remote_.begin_contact();
  }
  held_ = force;
  return -force;
}

double PositionForce::lead(const LeaderSample& s, std::span<const Datagram> arrived,
                           Datagram& out) {
  newest_.take(arrived);
  const double wanted = newest_.known() ? newest_->force : 0.0;
  const double force = bound_.step(Vec3(s.position, 0.0, 0.0), Vec3(wanted, 0.0, 0.0)).x();
  say(s, force, out);
  return force;
}

double PositionForceTwoPort::lead(const LeaderSample& s, std::span<const Datagram> arrived,
                                  Datagram& out) {
  for (const Datagram& d : arrived) bound_.take({d.energy, d.energy_back, d.pushed});
  newest_.take(arrived);
  const double wanted = newest_.known() ? newest_->force : 0.0;
  const double force = bound_
                           .step(Vec3(s.position, 0.0, 0.0), Vec3(wanted, 0.0, 0.0),
                                 newest_.known() && !newest_->touching)
                           .x();
  say(s, force, out);
  return force;
}

FollowerForce PositionForceTwoPort::follow(const FollowerSample& s,
                                           std::span<const Datagram> arrived, Datagram& out) {
  counted_.moved(Vec3(s.force, 0.0, 0.0), moved(follower_before_, Vec3(s.position, 0.0, 0.0)),
                 period_);
  const FollowerForce force = follower_.step(s, arrived, out);
  out.energy = counted_.counters().given;
  out.energy_back = counted_.counters().taken;
  out.pushed = counted_.counters().pushed;
  out.touching = std::abs(s.force) > kTouches;
  return force;
}

Vec3 SpatialPositionForce::lead(const SpatialLeaderSample& s,
                                std::span<const SpatialDatagram> arrived, SpatialDatagram& out) {
  newest_.take(arrived);
  const Vec3 wanted = newest_.known() ? newest_->force : Vec3::Zero();
  Vec3 force = bound_.step(s.position, wanted);
  say(s, force, out);
  return force;
}

Vec3 SpatialTwoPortForce::lead(const SpatialLeaderSample& s,
                               std::span<const SpatialDatagram> arrived, SpatialDatagram& out) {
  for (const SpatialDatagram& d : arrived) bound_.take(d.counted);
  newest_.take(arrived);
  const Vec3 wanted = newest_.known() ? newest_->force : Vec3::Zero();
  Vec3 force = bound_.step(s.position, wanted, newest_.known() && !newest_->touching);
  say(s, force, out);
  return force;
}

SpatialFollowerForce SpatialTwoPortForce::follow(const SpatialFollowerSample& s,
                                                 std::span<const SpatialDatagram> arrived,
                                                 SpatialDatagram& out) {
  counted_.moved(s.force, moved(follower_before_, s.position), period_);
  SpatialFollowerForce force = follower_.step(s, arrived, out);
  out.counted = counted_.counters();
  out.touching = length(s.force) > kTouches;
  return force;
}

}  // namespace feltwire::teleop

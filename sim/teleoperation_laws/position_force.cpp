#include "sim/teleoperation_laws/position_force.hpp"

namespace feltwire::teleop {
namespace {

BoundingConfig config(const Plant& plant, std::string_view method) {
  BoundingConfig c;
  c.mode = method;
  c.period = plant.period;
  c.damping = Damping(plant.leader_damping);
  c.max_force = plant.leader_force;
  c.quantum = plant.leader_quantum;
  return c;
}

double moved(std::optional<double>& before, double now) {
  const double displacement = before ? now - *before : 0.0;
  before = now;
  return displacement;
}

void say(const LeaderSample& s, double force, Datagram& out) {
  out.position = s.position;
  out.velocity = s.velocity;
  out.force = force;
}

}  // namespace

PositionForce::PositionForce(const Plant& plant, std::string_view method)
    : period_(plant.period), bound_(config(plant, method)), follower_(plant) {}

double PositionForce::lead(const LeaderSample& s, std::span<const Datagram> arrived,
                           Datagram& out) {
  newest_.take(arrived);
  const double wanted = newest_.known() ? newest_->force : 0.0;
  BoundingStep step;
  step.displacement.x() = moved(before_, s.position);
  step.hold_time = period_;
  step.command.elastic = Vec3(-wanted, 0.0, 0.0);
  const double force = -bound_.step(step).rendered.elastic.x();
  say(s, force, out);
  return force;
}

PositionForceTwoPort::PositionForceTwoPort(const Plant& plant)
    : period_(plant.period),
      bound_(plant.leader_damping, plant.period),
      remote_(RemoteTrust{}),
      counted_(plant.wrench_noise),
      follower_(plant) {}

double PositionForceTwoPort::lead(const LeaderSample& s, std::span<const Datagram> arrived,
                                  Datagram& out) {
  for (const Datagram& d : arrived) remote_.take({d.energy, d.energy_back, d.pushed});
  newest_.take(arrived);
  const double wanted = newest_.known() ? newest_->force : 0.0;
  remote_.step(period_);
  const Vec3 force = bound_.step({.displacement = Vec3(moved(before_, s.position), 0.0, 0.0),
                                  .hold_time = period_,
                                  .command = Vec3(-wanted, 0.0, 0.0),
                                  .remote = remote_.net()});
  if (held_ == 0.0 && newest_.known() && !newest_->touching) {
    bound_.begin_contact();
    remote_.begin_contact();
  }
  held_ = -force.x();
  say(s, held_, out);
  return held_;
}

FollowerForce PositionForceTwoPort::follow(const FollowerSample& s,
                                           std::span<const Datagram> arrived, Datagram& out) {
  constexpr double kTouches = 0.1;  // [N]
  counted_.moved(Vec3(s.force, 0.0, 0.0), Vec3(moved(follower_before_, s.position), 0.0, 0.0),
                 period_);
  const FollowerForce force = follower_.step(s, arrived, out);
  out.energy = counted_.counters().given;
  out.energy_back = counted_.counters().taken;
  out.pushed = counted_.counters().pushed;
  out.touching = std::abs(s.force) > kTouches;
  return force;
}

}  // namespace feltwire::teleop

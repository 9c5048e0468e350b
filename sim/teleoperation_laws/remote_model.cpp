#include "sim/teleoperation_laws/remote_model.hpp"

#include <cmath>
#include <numbers>

namespace feltwire::teleop {

double RemoteModel::lead(const LeaderSample& s, std::span<const Datagram> arrived, Datagram& out) {
  for (const Datagram& d : arrived) leader_.take({d.energy, d.energy_back, d.pushed});
  from_follower_.take(arrived);
  RemoteContact contact;
  double age = 0.0;
  if (from_follower_.known()) {
    const Datagram& d = *from_follower_.operator->();
    contact = {.surface = d.surface,
               .touching = d.touching,
               .point = Vec3(d.place, 0.0, 0.0),
               .normal = -Vec3::UnitX(),
               .stiffness = d.stiffness,
               .friction = 0.0,
               .velocity = Vec3(d.surface_velocity, 0.0, 0.0)};
    age = s.time - d.time;
  }
  const Vec3 held =
      leader_.step(Vec3(s.position, 0.0, 0.0), Vec3(s.velocity, 0.0, 0.0), contact, age);
  out.position = s.position;
  out.velocity = s.velocity;
  out.wave = leader_.offset().x();
  out.surface = leader_.known_surface();
  out.energy = leader_.hand_work();
  return -held.x();
}

FollowerForce RemoteModel::follow(const FollowerSample& s, std::span<const Datagram> arrived,
                                  Datagram& out) {
  constexpr double kReferenceRate = 20.0;  // [Hz]
  from_leader_.take(arrived);
  const RemoteContact& contact = follower_.step(
      Vec3(s.position, 0.0, 0.0), Vec3(s.velocity, 0.0, 0.0), Vec3(s.force, 0.0, 0.0), prior_);
  out.position = s.position;
  out.surface = contact.surface;
  out.touching = contact.touching;
  out.place = contact.point.x();
  out.stiffness = contact.stiffness;
  out.surface_velocity = contact.velocity.x();
  out.energy = follower_.energy().given;
  out.energy_back = follower_.energy().taken;
  out.pushed = follower_.energy().pushed;
  if (!from_leader_.known()) return {0.0, plant_.controller_damping, 0.0};
  const Vec3 target =
      follower_.target({.index = from_leader_->index,
                        .wanted = Vec3(from_leader_->position - from_leader_->wave, 0.0, 0.0),
                        .known = from_leader_->surface,
                        .hand_work = from_leader_->energy,
                        .gripper = 0.0});
  const double speed = moved(target_before_, target).x() / plant_.period;
  target_speed_ += (1.0 - std::exp(-2.0 * std::numbers::pi * kReferenceRate * plant_.period)) *
                   (speed - target_speed_);
  return {plant_.stiffness * (target.x() - s.position), plant_.controller_damping, target_speed_};
}

}  // namespace feltwire::teleop

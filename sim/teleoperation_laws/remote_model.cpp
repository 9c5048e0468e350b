#include "sim/teleoperation_laws/remote_model.hpp"

#include <cmath>
#include <numbers>

namespace feltwire::teleop {

const Vec3& TargetVelocity::step(const Vec3& target, double period) {
  constexpr double kCutoff = 20.0;  // [Hz] cutoff frequency of the low-pass filter
  const Vec3 velocity = moved(before_, target) / period;
  velocity_ +=
      (1.0 - std::exp(-2.0 * std::numbers::pi * kCutoff * period)) * (velocity - velocity_);
  return velocity_;
}

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
      leader_.step(Vec3(s.position, 0.0, 0.0), Vec3(s.velocity, 0.0, 0.0), contact, {}, age);
  out.position = s.position;
  out.velocity = s.velocity;
  out.wave = leader_.offset().x();
  out.surface = leader_.known_surface();
  out.energy = leader_.hand_work();
  return -held.x();
}

FollowerForce RemoteModel::follow(const FollowerSample& s, std::span<const Datagram> arrived,
                                  Datagram& out) {
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
  return {plant_.stiffness * (target.x() - s.position), plant_.controller_damping,
          target_velocity_.step(target, plant_.period).x()};
}

Vec3 SpatialRemoteModel::lead(const SpatialLeaderSample& s,
                              std::span<const SpatialDatagram> arrived, SpatialDatagram& out) {
  for (const SpatialDatagram& d : arrived) leader_.take(d.counted);
  from_follower_.take(arrived);
  const bool known = from_follower_.known();
  const Vec3 held =
      leader_.step(s.position, s.velocity, known ? from_follower_->contact : RemoteContact{},
                   known ? from_follower_->others : OtherSurfaces{},
                   known ? s.time - from_follower_->time : 0.0);
  out.wanted = {.index = out.index,
                .wanted = s.position - leader_.offset(),
                .known = leader_.known_surface(),
                .hand_work = leader_.hand_work(),
                .gripper = 0.0};
  return -held;
}

SpatialFollowerForce SpatialRemoteModel::follow(const SpatialFollowerSample& s,
                                                std::span<const SpatialDatagram> arrived,
                                                SpatialDatagram& out) {
  from_leader_.take(arrived);
  const SurfacePrior prior = model_ ? model_(s.position) : SurfacePrior{};
  out.contact = follower_.step(s.position, s.velocity, s.force, prior);
  out.others = follower_.others();
  out.counted = follower_.energy();
  if (!from_leader_.known()) return {.damping = plant_.controller_damping};
  const Vec3 target = follower_.target(from_leader_->wanted);
  return {plant_.stiffness * (target - s.position), plant_.controller_damping,
          target_velocity_.step(target, plant_.period)};
}

}  // namespace feltwire::teleop

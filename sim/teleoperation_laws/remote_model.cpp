#include "sim/teleoperation_laws/remote_model.hpp"

#include <cmath>
#include <numbers>

#include "core/bounding/device_account.hpp"

namespace feltwire::teleop {
namespace {

DeviceSpec device(const Plant& plant) {
  DeviceSpec spec;
  spec.damping = Damping(plant.leader_damping);
  spec.least_mass = plant.leader_mass;
  spec.hand_force = plant.hand_force;
  spec.position_resolution = plant.leader_quantum;
  spec.max_force = plant.leader_force;
  return spec;
}

Vec3 moved(std::optional<Vec3>& before, const Vec3& now) {
  Vec3 displacement = before ? Vec3(now - *before) : Vec3::Zero();
  before = now;
  return displacement;
}

/// The springs of controller and surface, one behind the other.
double series(double a, double b) { return a * b / (a + b); }

}  // namespace

RemoteModel::RemoteModel(const Plant& plant)
    : plant_(plant),
      midpoint_(plant.leader_quantum),
      account_(account_config(device(plant), plant.period)),
      remote_(RemoteTrust{}),
      counted_(plant.wrench_noise),
      estimate_({.first_stiffness = plant.stiffness}),
      limiter_({.stiffness = plant.stiffness}) {}

/// The contact as a plane where the hand is to meet it.
void RemoteModel::show(const RemoteContact& contact, double now) {
  constexpr double kReach = 1.0;  // [m]
  LocalModel model;
  if (contact.surface != 0) {
    SurfacePatch& patch = model.patches.front();
    patch.point = contact.point + index_.offset();
    patch.normal = contact.normal;
    patch.velocity = contact.velocity;
    patch.radius = model.reach = kReach;
    patch.material.stiffness = series(contact.stiffness, plant_.stiffness);
    patch.object = static_cast<std::uint16_t>(contact.surface);
    model.center = Vec3(now, 0.0, 0.0);
    model.count = 1;
  }
  local_.take(model);
}

double RemoteModel::lead(const LeaderSample& s, std::span<const Datagram> arrived, Datagram& out) {
  for (const Datagram& d : arrived) remote_.take({d.energy, d.energy_back, d.pushed});
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
  const Vec3 hand(s.position, 0.0, 0.0);
  const Vec3 displacement = moved(hand_before_, hand);
  hand_work_ -= held_.dot(displacement);
  index_.step(hand, displacement, contact, plant_.period);
  show(contact, s.position);

  account_.credit(remote_.step(plant_.period));
  const Vec3 ahead = midpoint_.probe(displacement, Vec3::Zero()).offset;
  BoundingStep step;
  step.displacement = displacement;
  step.hold_time = plant_.period;
  step.command =
      local_.touch({hand + ahead, Vec3(s.velocity, 0.0, 0.0)}, age, plant_.period).command;
  step.command = midpoint_.step(step);
  const double force = length(step.command.force());
  if (force > plant_.leader_force) step.command = (plant_.leader_force / force) * step.command;
  const bool held_before = !held_.isZero(0.0);
  held_ = account_.step(step).force();
  if (held_before && held_.isZero(0.0) && !contact.touching) remote_.begin_contact();

  out.position = s.position;
  out.velocity = s.velocity;
  out.wave = index_.offset().x();
  out.surface = index_.known_surface();
  out.energy = hand_work_;
  return -held_.x();
}

FollowerForce RemoteModel::follow(const FollowerSample& s, std::span<const Datagram> arrived,
                                  Datagram& out) {
  constexpr double kReferenceRate = 20.0;  // [Hz]
  from_leader_.take(arrived);
  const Vec3 tip(s.position, 0.0, 0.0), force(s.force, 0.0, 0.0);
  const RemoteContact& contact = estimate_.step({.position = tip,
                                                 .velocity = Vec3(s.velocity, 0.0, 0.0),
                                                 .force = force,
                                                 .elapsed = plant_.period});
  counted_.moved(force, moved(tip_before_, tip), plant_.period);
  out.position = s.position;
  out.surface = contact.surface;
  out.touching = contact.touching;
  out.place = contact.point.x();
  out.stiffness = contact.stiffness;
  out.surface_velocity = contact.velocity.x();
  out.energy = counted_.counters().given;
  out.energy_back = counted_.counters().taken;
  out.pushed = counted_.counters().pushed;
  if (!from_leader_.known()) return {0.0, plant_.controller_damping, 0.0};
  const Vec3 wanted(from_leader_->position - from_leader_->wave, 0.0, 0.0);
  const Vec3 target = limiter_.step({.wanted = wanted,
                                     .robot = tip,
                                     .surface = contact.touching ? contact.surface : 0,
                                     .known = from_leader_->surface,
                                     .hand_work = from_leader_->energy,
                                     .elapsed = plant_.period});
  const double speed = moved(target_before_, target).x() / plant_.period;
  target_speed_ += (1.0 - std::exp(-2.0 * std::numbers::pi * kReferenceRate * plant_.period)) *
                   (speed - target_speed_);
  return {plant_.stiffness * (target.x() - s.position), plant_.controller_damping, target_speed_};
}

}  // namespace feltwire::teleop

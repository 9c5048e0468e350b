#include "sim/teleoperation_laws/remote_ends.hpp"

#include "core/base/numeric.hpp"
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

/// Returns the stiffness [N/m] of two springs in series: the controller of the robot and the
/// surface.
double series(double a, double b) { return a * b / (a + b); }

}  // namespace

Vec3 moved(std::optional<Vec3>& before, const Vec3& now) {
  Vec3 displacement = before ? Vec3(now - *before) : Vec3::Zero();
  before = now;
  return displacement;
}

RemoteLeader::RemoteLeader(const Plant& plant)
    : plant_(plant),
      midpoint_(plant.leader_quantum, plant.period),
      account_(account_config(device(plant), plant.period)),
      remote_(RemoteTrust{}) {}

/// Replaces the local model by a plane for each surface. Adds the leader's offset (position of the
/// hand minus target of the robot), because the surfaces are given in the coordinates of the robot.
void RemoteLeader::show(const RemoteContact& contact, const OtherSurfaces& others,
                        const Vec3& hand) {
  constexpr double kReach = 1.0;  // [m] radius of the planes, and reach of the model
  LocalModel model;
  const auto add = [&](const RemoteContact& surface) {
    SurfacePatch& patch = model.patches[static_cast<std::size_t>(model.count++)];
    patch.point = surface.point + surface_offset_.offset();
    patch.normal = surface.normal;
    patch.velocity = surface.velocity;
    patch.radius = kReach;
    patch.material.stiffness = series(surface.stiffness, plant_.stiffness);
    patch.material.static_friction = patch.material.dynamic_friction = surface.friction;
    patch.object = static_cast<std::uint16_t>(surface.surface);
  };
  if (contact.surface != 0) add(contact);
  for (const RemoteContact& other : others.view()) add(other);
  model.center = hand;
  if (model.count > 0) model.reach = kReach;
  local_.take(model);
}

Vec3 RemoteLeader::step(const Vec3& hand, const Vec3& velocity, const RemoteContact& contact,
                        const OtherSurfaces& others, double age) {
  const Vec3 displacement = moved(hand_before_, hand);
  hand_work_ -= held_.dot(displacement);
  surface_offset_.step(hand, displacement, contact, plant_.period, {}, others);
  show(contact, others, hand);

  account_.credit(remote_.step(plant_.period));
  const Vec3 ahead = midpoint_.probe(displacement, Vec3::Zero()).offset;
  BoundingStep step;
  step.displacement = displacement;
  step.hold_time = plant_.period;
  step.command = local_.touch({hand + ahead, velocity}, age, plant_.period).command;
  step.command = midpoint_.step(step);
  const double force = length(step.command.force());
  if (force > plant_.leader_force) step.command = (plant_.leader_force / force) * step.command;
  const bool held_before = !held_.isZero(0.0);
  held_ = account_.step(step).force();
  if (held_before && held_.isZero(0.0) && !contact.touching) remote_.begin_contact();
  return held_;
}

RemoteFollower::RemoteFollower(const Plant& plant)
    : plant_(plant),
      counted_(plant.wrench_noise),
      estimate_({.first_stiffness = plant.stiffness}),
      limiter_({.stiffness = plant.stiffness}) {}

const RemoteContact& RemoteFollower::step(const Vec3& tip, const Vec3& velocity, const Vec3& force,
                                          const SurfacePrior& prior) {
  tip_ = tip;
  force_ = force;
  const RemoteContact& contact = estimate_.step({.position = tip,
                                                 .velocity = velocity,
                                                 .force = force,
                                                 .elapsed = plant_.period,
                                                 .prior = prior});
  counted_.moved(force, moved(tip_before_, tip), plant_.period);
  return contact;
}

const Vec3& RemoteFollower::target(const LeaderState& newest) {
  const RemoteContact& contact = estimate_.contact();
  return limiter_.step({.wanted = newest.wanted,
                        .robot = tip_,
                        .force = force_,
                        .surface = contact.touching ? contact.surface : 0,
                        .known = newest.known,
                        .hand_work = newest.hand_work,
                        .elapsed = plant_.period});
}

}  // namespace feltwire::teleop

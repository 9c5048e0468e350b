// A tool with a body in a world: what stands and what moves answer it together, since it is one
// balance that it finds between them and the hand.

#include <algorithm>
#include <stdexcept>

#include "core/base/numeric.hpp"
#include "core/dynamics/world.hpp"

namespace feltwire {

/// [m] that a point of a grasp's tool may have gone from its last pose to the next.
double World::way_of(const Grasp& grasp, const Pose& next) const noexcept {
  if (!grasp.placed) return 0.0;
  const double radius = scene(grasp.held).tool().body->shell().radius;
  return length(Vec3(next.position - grasp.device.position)) +
         radius * length(rotation_between(grasp.device.orientation, next.orientation));
}

Grasp World::grasp(const Scene& held, const HandLimits& limits) const {
  const auto found = std::ranges::find(held_, &held, &Held::scene);
  if (found == held_.end())
    throw std::invalid_argument("scene '" + held.name() +
                                "' is not this world's; ask for a grasp of one of its tools");
  Grasp grasp;
  grasp.most_force = limits.force;
  grasp.pace = HandPace(limits.speed, tick_, kRecovery);
  grasp.held = static_cast<std::size_t>(found - held_.begin());
  grasp.forces.assign(parts_, Vec3::Zero());
  grasp.torques.assign(parts_, Vec3::Zero());
  grasp.strains.resize(parts_);
  grasp.near.parts.reserve(parts_);
  grasp.nearness.assign(parts_, Nearness::far);
  if (held.tool().body) grasp.motions.resize(held.objects().size());
  return grasp;
}

Command World::hold(const Pose& device, double elapsed, BodyMemory& memory,
                    Grasp& grasp) const noexcept {
  if (grasp.resets != counters_.resets) {
    memory = {};  // the tool is where the hand is, and feels what moves from zero again
    grasp.resets = counters_.resets;
  }
  const double moved_for = tick_ * static_cast<double>(counters_.steps - grasp.steps);
  grasp.steps = counters_.steps;
  const double trust = trust_ * grasp.pace.trust(time());
  for (std::size_t i = 0; i < parts_; ++i)
    grasp.motions[still_ + i] = {moved_for * motions_[i].linear, moved_for * motions_[i].angular,
                                 trust};
  memory.known = false;
  const Held& held = held_[grasp.held];
  const BodyStep step =
      step_body(*held.scene->tool().body, held.objects, device, elapsed, memory, grasp.motions);
  grasp.tool = {memory.pose.position, Vec3::Zero()};
  for (std::size_t i = 0; i < parts_; ++i) {
    grasp.forces[i].setZero();
    grasp.torques[i].setZero();
  }
  for (const ObjectWrench& part : step.touched()) {
    if (part.object < still_) continue;
    grasp.forces[part.object - still_] += part.wrench.head<3>();
    grasp.torques[part.object - still_] += part.wrench.tail<3>();
  }
  return step.command;
}

Command World::touch(const Pose& device, const Vec3& velocity, double elapsed, BodyMemory& memory,
                     Grasp& grasp) const noexcept {
  if (grasp.motions.size() != objects().size() || !device.position.allFinite()) [[unlikely]]
    return {};
  if (!grasp.pace.follow(way_of(grasp, device), time())) memory = {};
  grasp.placed = true;
  Command command = hold(device, elapsed, memory, grasp);
  grasp.device = device;
  grasp.fresh = true;
  scene(grasp.held).add_guides({device.position, velocity}, command);
  return command.finite() ? command : Command{};
}

}  // namespace feltwire

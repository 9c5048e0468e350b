// A tool with a body in a world. Still and moving objects answer it together: the tool finds one
// balance between all of them and the hand.

#include <algorithm>
#include <stdexcept>

#include "core/base/numeric.hpp"
#include "core/dynamics/world.hpp"

namespace feltwire {

/// [m] Upper bound of the way of any point of a hand's tool from its last pose to the next.
double World::way_of(const BodyContactState& contacts, const Pose& next) const noexcept {
  if (!contacts.placed) return 0.0;
  const double radius = view(contacts.held).tool().body->shell().radius;
  return length(Vec3(next.position - contacts.device.position)) +
         radius * length(rotation_between(contacts.device.orientation, next.orientation));
}

BodyContactState World::contact_state(const ToolView& view, const HandLimits& limits) const {
  const auto found = std::ranges::find(held_, &view, &MovedView::view);
  if (found == held_.end())
    throw std::invalid_argument(
        "tool: is of another scene than this world; ask for a contact state of one of its tools");
  BodyContactState contacts;
  contacts.most_force = limits.force;
  contacts.pace = HandSpeedLimit(limits.speed, tick_, kRecovery);
  contacts.held = static_cast<std::size_t>(found - held_.begin());
  contacts.forces.assign(parts_, Vec3::Zero());
  contacts.torques.assign(parts_, Vec3::Zero());
  contacts.peak_pushes.resize(parts_);
  contacts.near.parts.reserve(parts_);
  contacts.nearness.assign(parts_, NeighbourState::far);
  if (view.tool().body) contacts.motions.resize(view.objects().size());
  return contacts;
}

Command World::hold(const Pose& device, double elapsed, BodyMemory& memory,
                    BodyContactState& contacts) const noexcept {
  if (contacts.resets != counters_.resets) {
    memory = {};  // the tool starts at the hand, and moving objects push from zero
    contacts.resets = counters_.resets;
  }
  const double moved_for = tick_ * static_cast<double>(counters_.steps - contacts.steps);
  contacts.steps = counters_.steps;
  const double trust = trust_ * contacts.pace.trust(time());
  for (std::size_t i = 0; i < parts_; ++i)
    contacts.motions[still_ + i] = {moved_for * motions_[i].linear, moved_for * motions_[i].angular,
                                    trust};
  memory.known = false;
  const MovedView& held = held_[contacts.held];
  const BodyTool& tool = *held.view->tool().body;
  const BodyStep step =
      step_body(tool, held.objects, device, elapsed, memory, contacts.motions,
                tool.inertia().mass > 0.0 ? std::optional(gravity()) : std::nullopt);
  contacts.tool = {memory.pose.position, Vec3::Zero()};
  for (std::size_t i = 0; i < parts_; ++i) {
    contacts.forces[i].setZero();
    contacts.torques[i].setZero();
  }
  for (const ObjectWrench& part : step.touched()) {
    if (part.object < still_) continue;
    contacts.forces[part.object - still_] += part.wrench.head<3>();
    contacts.torques[part.object - still_] += part.wrench.tail<3>();
  }
  return step.command;
}

Command World::touch(const Pose& device, const Vec3& velocity, double elapsed, BodyMemory& memory,
                     BodyContactState& contacts) const noexcept {
  if (contacts.motions.size() != objects().size() || !device.position.allFinite()) [[unlikely]]
    return {};
  if (!contacts.pace.follow(way_of(contacts, device), time())) memory = {};
  contacts.placed = true;
  // A tool with mass has already been moved through the ticks without a sample.
  if (view(contacts.held).tool().body->inertia().mass > 0.0)
    elapsed = std::max(0.0, elapsed - contacts.ahead);
  contacts.ahead = 0.0;
  Command command = hold(device, elapsed, memory, contacts);
  contacts.device = device;
  contacts.fresh = true;
  view(contacts.held).add_guides({device.position, velocity}, command);
  return command.finite() ? command : Command{};
}

}  // namespace feltwire

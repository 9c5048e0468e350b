#include "core/dynamics/body_tool_contact.hpp"

#include <algorithm>
#include <optional>

#include "core/base/numeric.hpp"

namespace feltwire {
namespace {

/// [m] Upper bound of the way of any point of a hand's tool from its last pose to the next.
double way_of(const BodyTool& tool, const BodyContactState& contacts, const Pose& next) {
  if (!contacts.placed) return 0.0;
  const double radius = tool.shell().radius;
  return length(Vec3(next.position - contacts.device.position)) +
         radius * length(rotation_between(contacts.device.orientation, next.orientation));
}

/// Moves the tool by `elapsed` [s], with the hand at `device`, and stores the forces of the moving
/// objects in the contacts.
Command balance(const MovingObjects& objects, const WorldMoment& moment, const Pose& device,
                double elapsed, BodyMemory& memory, BodyContactState& contacts) noexcept {
  if (contacts.resets != moment.resets) {
    memory = {};  // the tool starts at the hand, and moving objects push from zero
    contacts.resets = moment.resets;
  }
  const double moved_for = moment.tick * static_cast<double>(moment.steps - contacts.steps);
  contacts.steps = moment.steps;
  const double trust = moment.trust * contacts.pace.trust(moment.now);
  const std::size_t still = objects.still();
  for (std::size_t i = 0; i < objects.moving(); ++i) {
    const ObjectVelocity& velocity = objects.velocity(i);
    contacts.motions[still + i] = {moved_for * velocity.linear, moved_for * velocity.angular,
                                   trust};
  }
  memory.known = false;
  const MovedView& moved = objects.views()[contacts.held];
  const BodyTool& tool = *moved.view->tool().body;
  const BodyStep step =
      step_body(tool, moved.objects, device, elapsed, memory, contacts.motions,
                tool.inertia().mass > 0.0 ? std::optional(moment.gravity) : std::nullopt);
  contacts.tool = {memory.pose.position, Vec3::Zero()};
  for (std::size_t i = 0; i < objects.moving(); ++i) {
    contacts.forces[i].setZero();
    contacts.torques[i].setZero();
  }
  for (const ObjectWrench& part : step.touched()) {
    if (part.object < still) continue;
    contacts.forces[part.object - still] += part.wrench.head<3>();
    contacts.torques[part.object - still] += part.wrench.tail<3>();
  }
  return step.command;
}

}  // namespace

Command touch(const MovingObjects& objects, const WorldMoment& moment, const Pose& device,
              const Vec3& velocity, double elapsed, BodyMemory& memory,
              BodyContactState& contacts) noexcept {
  if (contacts.motions.size() != objects.still() + objects.moving() || !device.position.allFinite())
      [[unlikely]]
    return {};
  const ToolView& view = *objects.views()[contacts.held].view;
  const BodyTool& tool = *view.tool().body;
  if (!contacts.pace.follow(way_of(tool, contacts, device), moment.now)) memory = {};
  contacts.placed = true;
  // A tool with mass has already been moved through the ticks without a sample.
  if (tool.inertia().mass > 0.0) elapsed = std::max(0.0, elapsed - contacts.ahead);
  contacts.ahead = 0.0;
  Command command = balance(objects, moment, device, elapsed, memory, contacts);
  contacts.device = device;
  contacts.fresh = true;
  view.add_guides({device.position, velocity}, command);
  return command.finite() ? command : Command{};
}

bool hold_still(const MovingObjects& objects, const WorldMoment& moment, BodyMemory& memory,
                BodyContactState& contacts) noexcept {
  if (contacts.forces.size() != objects.moving()) [[unlikely]]
    return false;
  if (!contacts.fresh || contacts.resets != moment.resets) {
    balance(objects, moment, contacts.device, moment.tick, memory, contacts);
    contacts.ahead += moment.tick;
  }
  contacts.fresh = false;
  return true;
}

}  // namespace feltwire

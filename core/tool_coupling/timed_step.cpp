#include "core/tool_coupling/timed_step.hpp"

#include <algorithm>
#include <cmath>
#include <optional>

#include "core/base/numeric.hpp"
#include "core/tool_coupling/descent.hpp"

namespace feltwire {
namespace {

using tool_coupling::Dashpot;
using tool_coupling::descend;
using tool_coupling::Pull;
using tool_coupling::pull;
using tool_coupling::resistance;
using tool_coupling::State;
using tool_coupling::Step;

/// Returns the damper of the coupling. Its resistance is reduced if spring and damper together
/// would exceed the largest force of the coupling.
Dashpot dashpot_of(const CoupledTool& tool, const Pull& pull, const Pose& before,
                   const Pose& device, double elapsed, const BodyMemory& memory) {
  const ToolInertia& body = *tool.inertia;
  Dashpot dashpot;
  dashpot.device_way << device.position - before.position,
      rotation_between(before.orientation, device.orientation);
  const Vec3 arm = memory.pose.orientation * body.center;
  Vec6 free;
  free << memory.velocity.linear - memory.velocity.angular.cross(arm), memory.velocity.angular;
  const Vec6 against = dashpot.device_way - elapsed * free;
  const auto limited = [](double damper, double room, double way) {
    return damper * way > std::max(0.0, room) ? std::max(0.0, room) / way : damper;
  };
  const double linear =
      limited(body.damping / elapsed, tool.coupling.max_force - length(pull.wrench.head<3>()),
              length(against.head<3>()));
  const double rotational =
      limited(body.rotational_damping / elapsed,
              tool.coupling.max_torque - length(pull.wrench.tail<3>()), length(against.tail<3>()));
  dashpot.drag << Vec3::Constant(linear), Vec3::Constant(rotational);
  return dashpot;
}

/// The result of a time step. It is filled in place, because a state takes about 5 kB.
struct End {
  State state;
  ToolVelocity velocity = {};
  Vec6 damper = Vec6::Zero();        // [N], [N m] force of the damper on the tool
  double work = 0.0;                 // [J] work of the hand on the coupling
  std::optional<State> middle = {};  // state at the midpoint, where contact forces act
  FrictionSolution last = {};
  Vec6 resisted = Vec6::Zero();  // [N], [N m] force of friction and contact dampers
  bool slipping = false;
};

/// A time step, with the device's pose before and after it.
struct TimeStep {
  const CoupledTool& tool;
  const ToolSurroundings& surroundings;
  const Pose& before;
  const Pose& device;
  double elapsed;
  const BodyMemory& memory;
  const ShellContact& met;  // contact at the beginning of the step
  BodyStep& result;

  Pull pull_at(const Pose& at_device) const { return pull(tool.coupling, at_device, memory.pose); }
  State start(const Pose& at_device) const { return {memory.pose, pull_at(at_device), met}; }
  double kinetic() const {
    return kinetic_energy(*tool.inertia, memory.pose.orientation, memory.velocity);
  }

  /// Slows the tool down until its kinetic energy is at most `left`. Returns false if `left` is
  /// negative, because the tool cannot have such a pose.
  bool settle(End& end, double left) const {
    if (!(left >= 0.0)) return false;
    const double has = kinetic_energy(*tool.inertia, end.state.pose.orientation, end.velocity);
    if (has > left) {
      const double slower = std::sqrt(left / has);
      end.velocity.linear *= slower;
      end.velocity.angular *= slower;
    }
    return true;
  }

  /// Computes the force of the damper at the end of the step. Returns the work [J] of the damper on
  /// the tool.
  double take_damper(const Dashpot& dashpot, End& end) const {
    Vec6 way;
    way << end.state.pose.position - memory.pose.position,
        rotation_between(memory.pose.orientation, end.state.pose.orientation);
    end.damper = dashpot.wrench(way);
    const Vec6& spring = end.state.pull.wrench;
    const auto limit = [](auto&& part, double room) {
      const double size = length(part);
      if (size > room) part *= std::max(0.0, room) / size;
    };
    limit(end.damper.head<3>(), tool.coupling.max_force - length(spring.head<3>()));
    limit(end.damper.tail<3>(), tool.coupling.max_torque - length(spring.tail<3>()));
    end.work += end.damper.dot(dashpot.device_way);
    return end.damper.dot(way);
  }

  /// Leaves the tool at its start, because no other pose is possible or no time passes.
  void stay(End& end, const ToolVelocity& velocity) const {
    end = {start(device), velocity};
    end.work = end.state.pull.energy - pull_at(before).energy;
  }

  bool implicit(End& end, bool damped_coupling) const {
    const InertialStep inertial(*tool.inertia, memory.pose, memory.velocity, elapsed, 1.0);
    Step step{tool, surroundings, device, elapsed, result};
    step.inertial = &inertial;
    step.budget = result.evaluations + kToolEvaluations;
    end = {start(device)};
    State& state = end.state;
    if (damped_coupling)
      step.dashpot = dashpot_of(tool, state.pull, before, device, elapsed, memory);
    state.inertial = inertial.energy(state.pose);
    end.work = state.pull.energy - pull_at(before).energy;
    const double had = kinetic() + state.pull.energy + state.contact.energy;
    end.slipping = memory.slipping;
    step.damp(state, end.slipping);
    end.last = descend(step, state, end.slipping);
    end.velocity = inertial.velocity(state.pose);
    end.resisted = resistance(step, state, end.last);
    const double damped = take_damper(step.dashpot, end);
    const double has =
        state.pull.energy + state.contact.energy + inertial.weight_energy(state.pose);
    return settle(end, had - has - step.paid + damped);
  }

  /// Makes a step by the midpoint rule. During the search, the device is also at its midpoint.
  bool midpoint(End& end) const {
    const InertialStep inertial(*tool.inertia, memory.pose, memory.velocity, elapsed, 0.5);
    const Vec3 by = device.position - before.position;
    const Vec3 turn = rotation_between(before.orientation, device.orientation);
    Step step{tool, surroundings, moved(before, 0.5 * by, 0.5 * turn), elapsed, result};
    step.inertial = &inertial;
    step.frictionless = true;
    // Reserve work for the implicit step, because it may have to replace this step.
    if (tool.work != nullptr) step.reserve = tool.work->left() / 2;
    const Pull begins = pull_at(before);
    State& state = end.middle.emplace(start(step.device));
    const Dashpot dashpot = dashpot_of(tool, state.pull, before, device, elapsed, memory);
    step.dashpot = {2.0 * dashpot.drag, 0.5 * dashpot.device_way};
    state.inertial = inertial.energy(state.pose);
    end.slipping = false;
    end.last = descend(step, state, end.slipping);
    end.velocity = inertial.velocity(state.pose);
    // The second half of the path is not searched for contacts, so its length must be within the
    // clearance.
    const Pose whole = inertial.whole(state.pose);
    Vec6 beyond;
    beyond << whole.position - state.pose.position,
        rotation_between(state.pose.orientation, whole.orientation);
    if (step.length_of(beyond) > state.contact.clearance + kToolAdvance) return false;
    step.device = device;
    end.state = step.at(whole);
    const double spring_work =
        0.5 * (begins.wrench + end.state.pull.wrench).dot(dashpot.device_way);
    end.work = spring_work;
    const double damped = take_damper(dashpot, end);
    const double had = kinetic() + begins.energy + met.energy + spring_work;
    const double has =
        end.state.pull.energy + end.state.contact.energy + inertial.weight_energy(end.state.pose);
    return settle(end, had - has + damped);
  }

  /// Returns true if enough work is left for two steps, because an implicit step follows a failed
  /// midpoint step.
  bool has_room_for_midpoint() const {
    constexpr std::uint64_t kTimes = 4;  // multiple of the work so far
    return tool.work == nullptr || tool.work->left() >= kTimes * tool.work->done();
  }

  bool may_take_midpoint() const {
    // The midpoint rule conserves energy. Friction and dampers take energy, so the rule is then
    // unnecessary.
    return tool.inertia->integration == ToolIntegration::midpoint && elapsed <= kLongestMidpoint &&
           has_room_for_midpoint() && met.grip_count == 0 && met.damping.resistance.isZero(0.0) &&
           met.viscosity.resistance.isZero(0.0);
  }

  void go(End& end) const {
    if (may_take_midpoint() && midpoint(end)) return;
    if (!implicit(end, true) && !implicit(end, false)) stay(end, {});
  }
};

/// Splits the force on the hand into an elastic part and the rest. Inertia, weight and damper
/// belong to no surface, and may take a part of the contact force. So the elastic part is limited
/// to the force on the hand.
Command command_of(const Vec6& on_tool, const ShellContact& contact) {
  Command command;
  const Vec3 force = -on_tool.head<3>();
  const Polar<double> pushed = polar(Vec3(contact.wrench.head<3>()));
  command.elastic = std::clamp(force.dot(pushed.direction), 0.0, pushed.length) * pushed.direction;
  command.frictional = force - command.elastic;
  command.torque = -on_tool.tail<3>();
  return command;
}

}  // namespace

void step_with_mass(const CoupledTool& tool, const ToolSurroundings& surroundings,
                    const Pose& device, double elapsed, BodyMemory& memory,
                    BodyStep& result) noexcept {
  if (!memory.known) {
    memory.contact = surroundings.contact(memory.pose, tool.work);
    ++result.evaluations;
    result.looked_at += memory.contact.looked_at;
  }
  const Pose before = memory.device_known ? memory.device : device;
  const TimeStep step{tool, surroundings, before, device, elapsed, memory, memory.contact, result};
  End end{};
  if (elapsed > 0.0 && std::isfinite(elapsed))
    step.go(end);
  else
    step.stay(end, memory.velocity);
  const double kinetic = kinetic_energy(*tool.inertia, end.state.pose.orientation, end.velocity);
  if (is_cut(tool.work) || !tool_coupling::usable(end.state) || !end.damper.allFinite() ||
      !std::isfinite(kinetic)) [[unlikely]]
    return;
  memory.pose = end.state.pose;
  memory.velocity = end.velocity;
  memory.device = device;
  memory.device_known = true;
  memory.contact = end.state.contact;
  memory.known = true;
  memory.slipping = end.slipping;
  result.command = command_of(end.state.pull.wrench + end.damper, end.state.contact);
  const State& pushed = end.middle ? *end.middle : end.state;
  tool_coupling::share_out(pushed, end.last, pushed.contact.wrench + end.resisted, result);
  result.stored = end.state.pull.energy + end.state.contact.energy;
  result.kinetic = kinetic;
  result.work = end.work;
  result.touching = end.state.contact.touching;
}

}  // namespace feltwire

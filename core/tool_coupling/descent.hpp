#pragma once
// Internal to the steps of a coupled tool: how its pose goes down an energy.

#include "core/tool_coupling/friction_solver.hpp"
#include "core/tool_coupling/tool_coupling.hpp"

namespace feltwire::tool_coupling {

/// The pull of the device on the tool.
struct Pull {
  double energy = 0.0;         // [J]
  Vec6 wrench = Vec6::Zero();  // on the tool
  double stiffness = 0.0, rotational_stiffness = 0.0;
};

/// The spring between a device and a tool at these poses.
Pull pull(const ToolCoupling& c, const Pose& device, const Pose& tool);

/// Everything at one pose of the tool.
struct State {
  Pose pose;
  Pull pull;
  ShellContact contact;
  double inertial = 0.0;  // [J] of InertialStep
  double energy() const { return pull.energy + contact.energy + inertial; }
};

/// The damper of the coupling in a step: a parabola in the way of the tool against the device's.
struct Dashpot {
  Vec6 drag = Vec6::Zero();        // [N/m], [N m/rad] of each component: resistance over the time
  Vec6 device_way = Vec6::Zero();  // [m], [rad] of the device in the step

  Vec6 wrench(const Vec6& way) const { return drag.cwiseProduct(device_way - way); }
  double work(const Vec6& way) const { return 0.5 * (device_way - way).dot(wrench(way)); }
};

/// The values that stay the same within a step.
struct Step {
  const CoupledTool& tool;
  const ToolSurroundings& surroundings;
  Pose device;
  double elapsed;
  BodyStep& result;
  // These follow from the state at the beginning.
  Mat6 damping = Mat6::Zero();  // over the time: [N/m] ...
  Vec6 driven = Vec6::Zero();
  Vec6 done = Vec6::Zero();               // how far the tool has moved
  double paid = 0.0;                      // [J] to friction and to the dampers of contacts
  std::size_t budget = kToolEvaluations;  // of all contacts, after which the descent ends
  std::uint64_t reserve = 0;  // units of work that the descent leaves for what comes after it
  // Only a tool with mass uses these.
  const InertialStep* inertial = nullptr;
  Dashpot dashpot = {};
  bool frictionless = false;

  State at(const Pose& pose) const;

  /// Whether the work that is left is enough for what took `units` before, and a half more.
  bool has_room_for(std::uint64_t units) const {
    return tool.work == nullptr || tool.work->left() >= reserve + units + units / 2;
  }

  double length_of(const Vec6& way) const {
    return way.head<3>().norm() + tool.radius * way.tail<3>().norm();
  }

  /// The minimum of the Gauss-Newton model of the energy, with the cost of sliding and damping.
  FrictionSolution model(const State& state, bool slipping) const;

  std::span<const FrictionPatch> gripping(const State& state) const {
    return frictionless ? std::span<const FrictionPatch>() : state.contact.gripping();
  }

  /// No farther than the clearance allows.
  Vec6 allowed(const State& state, const Vec6& way) const;

  /// [N], [N m] on a tool that has moved so far since the beginning.
  Vec6 damped(const Vec6& moved_by) const { return driven - damping * moved_by; }
  double damping_work(const Vec6& moved_by) const {
    return moved_by.dot(0.5 * (damping * moved_by) - driven);
  }

  /// Takes the dampers of what is touched at the beginning; of those along the normals no more than
  /// what still pushes where a tool that leaves ends up without them.
  void damp(const State& state, bool slipping);
};

/// Goes down from a state. Returns what the tool would do further, and what holds it. It ends where
/// the work that is left may not be enough for one more look: each look leaves the tool lower. If
/// there is not enough for the first one, the work is cut off.
FrictionSolution descend(Step& step, State& state, bool& slipping);

/// Finite, with an orientation.
bool good(const Pose& pose);
/// No pose beyond what products can hold.
bool usable(const State& state);

/// [N], [N m] of friction and of the contacts' dampers on the tool.
Vec6 resistance(const Step& step, const State& state, const FrictionSolution& last);

/// `whole`, the wrench of all objects on the tool, among those that are touched.
void share_out(const State& state, const FrictionSolution& last, const Vec6& whole,
               BodyStep& result);

}  // namespace feltwire::tool_coupling

#include "core/coupled_tool/coupled_tool.hpp"

#include <Eigen/Cholesky>
#include <algorithm>
#include <cmath>

#include "core/base/numeric.hpp"
#include "core/coupled_tool/friction_solver.hpp"

namespace feltwire {
namespace {

/// A spring that pulls with no more than `most`.
struct Spring {
  double stiffness, most;

  /// [J] Quadratic up to where it saturates, linear beyond.
  double energy(double stretch) const {
    const double linear_from = most / stiffness;
    return stretch <= linear_from ? 0.5 * stiffness * stretch * stretch
                                  : most * (stretch - 0.5 * linear_from);
  }
  /// Force over stretch: also the stiffness of the parabola that touches the energy there and lies
  /// above it everywhere.
  double secant(double stretch) const {
    return stiffness * stretch <= most ? stiffness : most / stretch;
  }
};

/// How the device pulls on the tool.
struct Pull {
  double energy = 0.0;         // [J]
  Vec6 wrench = Vec6::Zero();  // on the tool
  double stiffness = 0.0, rotational_stiffness = 0.0;
};

Pull pull(const ToolCoupling& c, const Pose& device, const Pose& tool) {
  const Spring linear{c.stiffness, c.max_force};
  const Spring rotational{c.rotational_stiffness, c.max_torque};
  const Vec3 stretch = device.position - tool.position;
  const Vec3 twist = rotation_between(tool.orientation, device.orientation);
  const double stretched = length(stretch), twisted = length(twist);
  Pull result;
  result.energy = linear.energy(stretched) + rotational.energy(twisted);
  result.stiffness = linear.secant(stretched);
  result.rotational_stiffness = rotational.secant(twisted);
  result.wrench << result.stiffness * stretch, result.rotational_stiffness * twist;
  return result;
}

/// Everything at one pose of the tool.
struct State {
  Pose pose;
  Pull pull;
  ShellContact contact;
  double energy() const { return pull.energy + contact.energy; }
};

/// The values that stay the same within a step.
struct Step {
  const CoupledTool& tool;
  const ToolSurroundings& surroundings;
  const Pose& device;
  double elapsed;
  BodyStep& result;
  // Of the state at the beginning.
  Mat6 damping = Mat6::Zero();  // over the time: [N/m] ...
  Vec6 driven = Vec6::Zero();
  Vec6 done = Vec6::Zero();  // how far the tool has moved

  State at(const Pose& pose) const {
    State state{pose, pull(tool.coupling, device, pose), surroundings.contact(pose)};
    ++result.evaluations;
    result.looked_at += state.contact.looked_at;
    return state;
  }

  double length_of(const Vec6& way) const {
    return way.head<3>().norm() + tool.radius * way.tail<3>().norm();
  }

  /// Where the Gauss-Newton model of the energy, with what sliding and damping cost, has its
  /// minimum.
  FrictionSolution model(const State& state, bool slipping) const {
    Mat6 stiffness = state.contact.stiffness + damping;
    stiffness.diagonal().head<3>().array() += state.pull.stiffness;
    stiffness.diagonal().tail<3>().array() += state.pull.rotational_stiffness;
    return solve_friction(stiffness, state.pull.wrench + state.contact.wrench + damped(done),
                          state.contact.gripping(), slipping);
  }

  /// No farther than the clearance allows.
  Vec6 allowed(const State& state, const Vec6& way) const {
    const double farthest = length_of(way), most = state.contact.clearance + kToolAdvance;
    return farthest > most ? Vec6(way * (most / farthest)) : way;
  }

  /// [N], [N m] on a tool that has moved so far since the beginning.
  Vec6 damped(const Vec6& moved_by) const { return driven - damping * moved_by; }
  double damping_work(const Vec6& moved_by) const {
    return moved_by.dot(0.5 * (damping * moved_by) - driven);
  }

  /// Takes the dampers of what is touched at the beginning; of those along the normals no more than
  /// what still pushes where a tool that leaves ends up without them.
  void damp(const State& state, bool slipping) {
    const ShellContact& contact = state.contact;
    if (!(elapsed > 0.0) || contact.part_count == 0) return;
    damping = contact.viscosity.resistance / elapsed;
    driven = contact.viscosity.driven / elapsed;
    if (contact.damping.resistance.isZero(0.0)) return;
    const Vec6 free = model(state, slipping).motion;
    const Mat6 full = contact.damping.resistance / elapsed;
    const double held = free.dot(full * free);
    const double pushed = free.dot(contact.wrench - contact.stiffness * free);
    double share = 1.0;
    if (contact.wrench.dot(free) > 0.0 && held > pushed) share = std::max(0.0, pushed / held);
    damping += share * full;
    driven += share / elapsed * contact.damping.driven;
  }
};

/// Goes down from a state. Returns what the tool would do further, and what holds it.
FrictionSolution descend(Step& step, State& state, bool& slipping) {
  // Of the radius: what is not worth a look, and not worth another one in the same step.
  constexpr double kClose = 1e-5, kCloseEnough = 1e-4;
  const double radius = step.tool.radius;
  const std::size_t before = step.result.evaluations;
  const auto next_slide = [&] {
    FrictionSolution next = step.model(state, slipping);
    if (next.slips && !slipping) {
      slipping = true;
      next = step.model(state, slipping);
    }
    return next;
  };
  FrictionSolution next = next_slide();
  bool slips = next.slips;  // at any time in this step
  Vec6 way = step.allowed(state, next.motion);
  // Objects that move are followed however slow they are.
  const double least = step.tool.surroundings_move ? 0.0 : kClose * radius;
  while (step.result.evaluations < kToolEvaluations) {
    const bool first = step.result.evaluations == before;
    if (!(step.length_of(way) > (first ? least : kCloseEnough * radius))) break;
    State tried = step.at(moved(state.pose, way.head<3>(), way.tail<3>()));
    const std::span<const FrictionPatch> patches = state.contact.gripping();
    const double cost = friction_work(patches, slipping, way) -
                        friction_work(patches, slipping, Vec6::Zero()) +
                        step.damping_work(step.done + way) - step.damping_work(step.done);
    if (tried.energy() + cost < state.energy()) {
      state = tried;
      step.done += way;
      // The tool has gone with what carries it; from here on it slips.
      for (std::size_t i = 0; i < state.contact.grip_count; ++i)
        state.contact.patches[i].carried.setZero();
      next = next_slide();
      slips |= next.slips;
      way = step.allowed(state, next.motion);
    } else {
      way *= 0.5;
    }
  }
  slipping = slips && state.contact.grip_count > 0;
  return next;
}

bool good(const Pose& pose) {
  const double squared = pose.orientation.squaredNorm();
  return pose.position.allFinite() && std::isfinite(squared) && squared > 0.0;
}

/// The command's wrench among the objects that are touched.
void share_out(const State& state, const FrictionSolution& last, BodyStep& result) {
  const ShellContact& contact = state.contact;
  const auto parts = std::span(result.parts).first(contact.part_count);
  std::copy_n(contact.parts.begin(), parts.size(), parts.begin());
  Vec6 rest = -state.pull.wrench;
  double sizes = 0.0;
  for (ObjectWrench& part : parts) {
    for (std::size_t i = 0; i < contact.grip_count; ++i)
      if (contact.patches[i].object == part.object) part.wrench += last.friction[i];
    rest -= part.wrench;
    sizes += part.wrench.head<3>().norm();
  }
  if (!(sizes > 0.0)) return;
  result.part_count = parts.size();
  for (ObjectWrench& part : parts) part.wrench += part.wrench.head<3>().norm() / sizes * rest;
}

}  // namespace

Pose moved(const Pose& pose, const Vec3& by, const Vec3& turn) noexcept {
  return {pose.position + by, turned(pose.orientation, turn)};
}

BodyStep step_coupled_tool(const CoupledTool& tool, const ToolSurroundings& surroundings,
                           const Pose& device, double elapsed, BodyMemory& memory) noexcept {
  BodyStep result;
  if (!good(device)) return result;
  if (!memory.placed) {
    memory.pose = device;
    memory.pose.orientation.normalize();
    memory.placed = true;
  }
  Step step{tool, surroundings, device, elapsed, result};
  State state = memory.known
                    ? State{memory.pose, pull(tool.coupling, device, memory.pose), memory.contact}
                    : step.at(memory.pose);
  bool slipping = memory.slipping;
  step.damp(state, slipping);
  const FrictionSolution last = descend(step, state, slipping);
  if (!std::isfinite(state.energy()) || !state.pull.wrench.allFinite() || !good(state.pose))
      [[unlikely]]
    return result;  // poses beyond what products can hold
  memory.pose = state.pose;
  memory.contact = state.contact;
  memory.known = true;
  memory.slipping = slipping;
  Vec6 resisted = step.damped(step.done);
  for (std::size_t i = 0; i < state.contact.grip_count; ++i) resisted += last.friction[i];
  result.command.frictional = resisted.head<3>();
  result.command.elastic = -state.pull.wrench.head<3>() - result.command.frictional;
  result.command.torque = -state.pull.wrench.tail<3>();
  share_out(state, last, result);
  result.stored = state.energy();
  result.touching = state.contact.touching;
  return result;
}

}  // namespace feltwire

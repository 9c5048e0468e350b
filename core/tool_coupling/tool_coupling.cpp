#include "core/tool_coupling/tool_coupling.hpp"

#include "core/tool_coupling/descent.hpp"
#include "core/tool_coupling/timed_step.hpp"

namespace feltwire {

Pose moved(const Pose& pose, const Vec3& by, const Vec3& turn) noexcept {
  return {pose.position + by, turned(pose.orientation, turn)};
}

BodyStep step_coupled_tool(const CoupledTool& tool, const ToolSurroundings& surroundings,
                           const Pose& device, double elapsed, BodyMemory& memory) noexcept {
  BodyStep result;
  if (!tool_coupling::good(device)) return result;
  if (!memory.placed) {
    memory.pose = device;
    memory.pose.orientation.normalize();
    memory.placed = true;
  }
  if (tool.inertia != nullptr && tool.inertia->mass > 0.0) {
    step_with_mass(tool, surroundings, device, elapsed, memory, result);
    return result;
  }
  tool_coupling::Step step{tool, surroundings, device, elapsed, result};
  tool_coupling::State state =
      memory.known ? tool_coupling::State{memory.pose,
                                          tool_coupling::pull(tool.coupling, device, memory.pose),
                                          memory.contact}
                   : step.at(memory.pose);
  bool slipping = memory.slipping;
  step.damp(state, slipping);
  const FrictionSolution last = descend(step, state, slipping);
  if (is_cut(tool.work) || !tool_coupling::usable(state)) [[unlikely]]
    return result;  // A product of the poses has overflowed.
  memory.pose = state.pose;
  memory.contact = state.contact;
  memory.known = true;
  memory.slipping = slipping;
  result.command.frictional = tool_coupling::resistance(step, state, last).head<3>();
  result.command.elastic = -state.pull.wrench.head<3>() - result.command.frictional;
  result.command.torque = -state.pull.wrench.tail<3>();
  tool_coupling::share_out(state, last, -state.pull.wrench, result);
  result.stored = state.energy();
  result.touching = state.contact.touching;
  return result;
}

}  // namespace feltwire

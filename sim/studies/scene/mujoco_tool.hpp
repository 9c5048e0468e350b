#pragma once
// Internal to the study of tools in six degrees of freedom: the same tool and solid in MuJoCo.

#include "core/dynamics/mujoco_error_trap.hpp"
#include "core/tool_coupling/tool_contact.hpp"
#include "sim/studies/scene/sixdof_tool.hpp"

namespace feltwire {

/// A tool with mass as a free body, its convex parts and those of the solid as geoms without
/// friction. Each contact is as stiff as the material for the tool's whole mass, and critically
/// damped. The coupling's spring and damper pull on the tool. A pocket is six thick walls.
class MujocoTool {
 public:
  /// `tool`: one with mass, for its coupling and inertia.
  MujocoTool(const SixDofTask& task, const SixDofTool& tool);

  /// Places the tool at the device, at rest.
  void place(const Pose& device);

  /// mj_step() with the device at a pose. Returns the force [N] and torque [N m] of the coupling on
  /// the hand, after the step.
  Vec6 step(const Pose& device);

  std::size_t bytes() const;  // of the model

 private:
  Pose pose() const;
  Vec6 pull(const Pose& device) const;

  BodyTool tool_;
  mujoco::Model model_;
  mujoco::Data data_;
  Pose before_;           // of the device
  Vec6 device_velocity_;  // [m/s], [rad/s]
};

}  // namespace feltwire

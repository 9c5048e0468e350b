#pragma once
// A tool without mass, coupled to the device by a spring: its balance with the contacts.

#include "core/coupled_tool/part_pairs.hpp"
#include "core/coupled_tool/tool_contact.hpp"

namespace feltwire {

/// The spring between device and tool, linear and rotational; each part saturates.
struct ToolCoupling {
  double stiffness = 1000.0;          // [N/m], > 0
  double rotational_stiffness = 0.0;  // [N m/rad]; 0: stiffness times the shell's radius squared
  double max_force = 20.0;            // [N], > 0
  double max_torque = 0.0;            // [N m]; 0: max_force times the shell's radius
};

/// The state of one tool in one scene: its pose, which contacts may keep away from the device's
/// pose.
struct BodyMemory {
  bool placed = false;
  Pose pose;
  /// The contact at that pose. Set known = false when the solids have moved since.
  ShellContact contact;
  bool known = false;
  bool slipping = false;  // along a surface; then dynamic friction acts
  PartPairs near;         // of a tool of polygons
};

/// Returns the pose moved by [m] and turned by a rotation vector [rad], world frame.
Pose moved(const Pose& pose, const Vec3& by, const Vec3& turn) noexcept;

/// The result of a step.
struct BodyStep {
  Command command;                             // on the hand: force in its parts, and torque
  double stored = 0.0;                         // [J] in coupling and contact after the step
  std::size_t touching = 0;                    // points
  std::size_t evaluations = 0, looked_at = 0;  // of all contacts; nodes and points in them
  /// The part of the command from each object, about the tool's origin. Their sum is the command,
  /// to rounding: a remaining imbalance is divided among them in proportion to their size.
  std::array<ObjectWrench, ShellContact::kFrictionPatches> parts;
  std::size_t part_count = 0;

  std::span<const ObjectWrench> touched() const { return {parts.data(), part_count}; }
};

/// The surroundings of a tool: the scene's solids, or a local model of them.
class ToolSurroundings {
 public:
  virtual ~ToolSurroundings() = default;
  /// The contact of the tool at a pose. Never allocates.
  virtual ShellContact contact(const Pose& tool) const noexcept = 0;
};

/// The properties of the tool for a step.
struct CoupledTool {
  const ToolCoupling& coupling;  // nothing in it is zero
  double radius;                 // [m] of the farthest point from the tool's origin, > 0
  bool surroundings_move = false;
};

/// Moves the tool towards the balance of coupling and contact. Returns the force and torque of the
/// coupling on the hand.
///
/// The tool has no mass. Its pose goes down the energy
///   E(tool) = E_coupling(device, tool) + sum over objects of E_contact(tool)
/// by Gauss-Newton steps with the analytic Jacobian (McNeely, Puterbaugh & Troy 2006, Voxel-based
/// 6-dof haptic rendering improvements; Barbic & James 2008). A step that does not lower E is
/// halved, so E grows only by the hand's work against the coupling's force. In one evaluation no
/// point moves farther than the clearance plus kToolAdvance, so that a fast hand does not take the
/// tool through a solid. The first step places the tool at the device.
///
/// A move must also pay for the friction, contact damping and viscous friction on its way
/// (core/coupled_tool/friction_solver.hpp). So a tool that they hold stays exactly where it is, and
/// they can only take energy. Damping is that of the contact at the beginning of the step, for the
/// way since then. On a tool that leaves a surface it is no stronger than the force that pushes the
/// tool out.
///
/// `elapsed`: [s] since the step before; at zero or less there is no damping.
///
/// A pose that is not finite gives zero and leaves the memory unchanged. Never allocates.
BodyStep step_coupled_tool(const CoupledTool& tool, const ToolSurroundings& surroundings,
                           const Pose& device, double elapsed, BodyMemory& memory) noexcept;

inline constexpr double kToolAdvance = 1e-3;  // [m]
inline constexpr std::size_t kToolEvaluations =
    8;  // largest number of evaluations of all contacts in a step

}  // namespace feltwire

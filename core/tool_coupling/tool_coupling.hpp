#pragma once
// A tool coupled to the device by a spring: without mass, its balance with the contacts; with mass,
// its movement.

#include "core/base/work_limit.hpp"
#include "core/tool_coupling/part_pairs.hpp"
#include "core/tool_coupling/tool_contact.hpp"
#include "core/tool_coupling/tool_inertia.hpp"

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
  // Only of a tool with mass. A memory that begins anew begins at rest.
  ToolVelocity velocity = {};
  Pose device = {};  // at the end of the last step, for the coupling's damper
  bool device_known = false;
};

/// Returns the pose moved by [m] and turned by a rotation vector [rad], world frame.
Pose moved(const Pose& pose, const Vec3& by, const Vec3& turn) noexcept;

/// The result of a step.
struct BodyStep {
  Command command;                             // on the hand: force in its parts, and torque
  double stored = 0.0;                         // [J] in coupling and contact after the step
  double kinetic = 0.0;                        // [J] of a tool with mass, after the step
  double work = 0.0;                           // [J] of the hand on a tool with mass, in the step
  std::size_t touching = 0;                    // points
  std::size_t evaluations = 0, looked_at = 0;  // of all contacts; nodes and points in them
  /// The part of the command from each object, about the tool's origin. Their sum is the command,
  /// to rounding: a remaining imbalance is divided among them in proportion to their size. Of a
  /// tool with mass it is what the object puts on the tool, which inertia and weight keep from the
  /// hand, or add to: the sum is then that of the objects.
  std::array<ObjectWrench, ShellContact::kFrictionPatches> parts;
  std::size_t part_count = 0;

  std::span<const ObjectWrench> touched() const { return {parts.data(), part_count}; }
};

/// The surroundings of a tool: the scene's solids, or a local model of them.
class ToolSurroundings {
 public:
  virtual ~ToolSurroundings() = default;
  /// The contact of the tool at a pose. Where `work` is cut off, the result means nothing. Never
  /// allocates.
  virtual ShellContact contact(const Pose& tool, WorkLimit* work) const noexcept = 0;
  ShellContact contact(const Pose& tool) const noexcept { return contact(tool, nullptr); }
};

/// The properties of the tool for a step.
struct CoupledTool {
  const ToolCoupling& coupling;  // nothing in it is zero
  double radius;                 // [m] of the farthest point from the tool's origin, > 0
  bool surroundings_move = false;
  const ToolInertia* inertia = nullptr;  // null, or of mass 0: the tool has no mass
  WorkLimit* work = nullptr;             // of the step; null: no limit
};

/// Moves the tool towards the balance of coupling and contact. Returns the force and torque of the
/// coupling on the hand.
///
/// A tool without mass: its pose goes down the energy
///   E(tool) = E_coupling(device, tool) + sum over objects of E_contact(tool)
/// by Gauss-Newton steps with the analytic Jacobian (McNeely, Puterbaugh & Troy 2006, Voxel-based
/// 6-dof haptic rendering improvements; Barbic & James 2008). A step that does not lower E is
/// halved, so E grows only by the hand's work against the coupling's force. In one evaluation no
/// point moves farther than the clearance plus kToolAdvance, so that a fast hand does not take the
/// tool through a solid. The first step places the tool at the device.
///
/// A move must also pay for the friction, contact damping and viscous friction on its way
/// (core/tool_coupling/friction_solver.hpp). So a tool that they hold stays exactly where it is,
/// and they can only take energy. Damping is that of the contact at the beginning of the step, for
/// the way since then. On a tool that leaves a surface it is no stronger than the force that pushes
/// the tool out.
///
/// A tool with mass goes down the incremental potential of a step of h = `elapsed` [s] (Kane et al.
/// 2000; Li et al. 2020, Incremental potential contact),
///   E(tool) + E_inertia(tool)   (core/tool_coupling/tool_inertia.hpp)
/// with the same costs of friction and damping and that of the coupling's damper, by the same
/// descent. Its minimum is the step of backward Euler; that of a step of h / 2, carried on as far
/// again, is the midpoint rule. A mass towards zero gives the balance above.
///
/// Energy. Let U be the energy of coupling, contact and gravity, K that of movement, and W the
/// work of the hand (BodyStep::work). Then
///   U' + K' <= U + K + W - (the cost of friction and contact dampers) - (the coupling damper's
///   loss)
/// at every step, whatever the shape of the contacts, the step's length and the error of the
/// descent. W is the device's way times the damper's force, plus for backward Euler the growth of U
/// while the device moves and the tool stands, and for the midpoint rule the device's way times the
/// mean of the spring's forces before and after. So a hand that stands gets no more than is stored.
///   Proof: what this leaves for K' is computed at the end of the step. Where K' is more, the
/// velocity is scaled down to it. Where it is below zero, a midpoint step is done again by backward
/// Euler, that without the coupling's damper, and there the tool stays where the step began, at
/// rest. How often? For backward Euler
/// each accepted step of the descent lowers a potential that begins at no more than U + K, so less
/// than zero is left only by the damper's part. With convex E and a converged descent not even the
/// velocity is scaled: K' - K = -grad E' . dx - |dv|^2_M / 2 <= E - E' - |dv|^2_M / 2. For the
/// midpoint rule and quadratic E, both sides are equal. Surfaces that move do work on the tool
/// beyond this.
///
/// The elastic part of the command is along the contact's force and at most that and the whole;
/// weight, inertia and the coupling's damper are in the frictional part. Spring and damper together
/// pull with at most max_force and max_torque.
///
/// The midpoint rule acts in steps of at most kLongestMidpoint that begin without friction or
/// damping of a contact: other steps are implicit, as the midpoint rule would answer a tool that
/// friction stops by throwing it back. A long pause so ends in the balance, at rest. So is a step
/// whose second half leads farther than the clearance in its middle plus kToolAdvance.
///
/// `elapsed`: [s] since the step before; at zero or less, or not finite, there is no damping, and a
/// tool with mass stays where it is with its velocity.
///
/// With less work than it would take, the descent ends sooner: the tool comes to its balance over
/// more steps. If the work is not enough for one look around, it is cut off.
///
/// A pose that is not finite gives zero and leaves the memory unchanged; so does a step whose work
/// is cut off, but for the first placing of the tool. Never allocates.
BodyStep step_coupled_tool(const CoupledTool& tool, const ToolSurroundings& surroundings,
                           const Pose& device, double elapsed, BodyMemory& memory) noexcept;

inline constexpr double kToolAdvance = 1e-3;       // [m]
inline constexpr double kLongestMidpoint = 10e-3;  // [s]
inline constexpr std::size_t kToolEvaluations =
    8;  // largest number of evaluations of all contacts in a step, or in one try of it

}  // namespace feltwire

#pragma once
// A tool with mass: its inertia, its velocity, and what one step of time costs it.

#include <cstdint>
#include <limits>

#include "core/tool_coupling/tool_contact.hpp"

namespace feltwire {

/// The rule by which a tool with mass is integrated over time.
///
///   implicit  backward Euler. Stable at every stiffness. It takes energy: of an oscillation with
///             w h [rad] a step, the amplitude falls by the factor 1 / sqrt(1 + (w h)^2) a step.
///   midpoint  the passive midpoint rule (Kim & Lee 2017, Haptic rendering and interactive
///             simulation using passive midpoint integration, IJRR 36(12)). It keeps the energy of
///             linear springs to rounding. Without damping, an impact on a frictionless surface is
///             elastic.
enum class ToolIntegration : std::uint8_t { implicit, midpoint };

/// The rigid body that the tool is, and the damper beside the coupling's spring.
struct ToolInertia {
  double mass = 0.0;            // [kg] > 0; 0: the tool has no mass, and the rest has no meaning
  Vec3 center = Vec3::Zero();   // [m, tool frame] of mass, from the tool's origin
  Mat3 inertia = Mat3::Zero();  // [kg m^2, tool frame] about the centre; positive definite
  Vec3 gravity = Vec3::Zero();  // [m/s^2, world frame]
  double damping = 0.0;         // [N s/m] >= 0, between the device and the tool's origin
  double rotational_damping = 0.0;  // [N m s/rad] >= 0
  ToolIntegration integration = ToolIntegration::implicit;
};

/// The velocity of a rigid body, world frame.
struct ToolVelocity {
  Vec3 linear = Vec3::Zero();   // [m/s] of the centre of mass
  Vec3 angular = Vec3::Zero();  // [rad/s]
};

/// [J]
double kinetic_energy(const ToolInertia& tool, const Quaternion& orientation,
                      const ToolVelocity& velocity) noexcept;

/// [m, world frame]
Vec3 center_of_mass(const ToolInertia& tool, const Pose& pose) noexcept;

/// The mean W_m of the angular velocities W and W' at the beginning and end of a free turn of
/// `elapsed` [s], all in the tool's frame [rad/s]. The turn is exp(elapsed W_m), and
///   I W' = exp(-elapsed W_m) I W,   W_m = (W + W') / 2
/// (the energy-momentum rule of Simo & Wong 1991, Unconditionally stable algorithms for rigid body
/// dynamics that exactly preserve energy and momentum, with the exponential map in place of
/// Cayley's, which keeps W_m too). The first equation keeps the angular momentum in the world.
/// Since W_m . I (W' - W) = 0, the kinetic energy is kept too, to the tolerance of the iteration,
/// which converges for elapsed |W| up to about 1. Always W_m . I W_m <= W . I W.
Vec3 free_turn(const Mat3& inertia, const Vec3& angular, double elapsed) noexcept;

/// A step of time goes down an energy. The tool's inertia and weight add this to it:
///   E_inertia(tool) = m / (2 h^2) |c - c~|^2 + phi . I~ phi / (2 h^2) - m g . (c - c_0)
/// c: the centre of mass; c~ and R~: where centre and orientation would be without any force, which
/// is c_0 + h v_0 and free_turn(); phi: the rotation vector from R~ to the tool's orientation; I~:
/// the inertia at R~, world frame. At the pose at the beginning, this is at most the kinetic
/// energy there.
class InertialStep {
 public:
  /// A step of `elapsed` [s] > 0 from `pose`. `share`: the part of the step whose end is searched
  /// for, 1 or 1/2; h above is share times elapsed.
  InertialStep(const ToolInertia& tool, const Pose& pose, const ToolVelocity& velocity,
               double elapsed, double share) noexcept;

  /// The energy and its derivatives at a pose; generalised vectors as in ShellContact.
  struct Term {
    Vec6 wrench = Vec6::Zero();     // [N], [N m] minus the gradient
    Mat6 stiffness = Mat6::Zero();  // [N/m] ... Gauss-Newton, positive definite
  };
  double energy(const Pose& pose) const noexcept;  // [J]
  Term term(const Pose& pose) const noexcept;

  /// The pose after the whole step, where the search ended at `found`: with a share of 1/2 it is as
  /// far beyond.
  Pose whole(const Pose& found) const noexcept;
  /// The velocity after the whole step, at the pose whole(found): by the impulse of the forces at
  /// `found`. So the angular momentum changes by exactly their torque.
  ToolVelocity velocity(const Pose& found) const noexcept;
  /// [J] energy() less the part that is kinetic: the potential of gravity, from the start.
  double weight_energy(const Pose& pose) const noexcept;

 private:
  struct Away {
    Vec3 center;  // [m] from c~
    Vec3 turn;    // [rad] phi
  };
  Away away(const Pose& pose) const noexcept;

  const ToolInertia& tool_;
  const Pose start_;
  const ToolVelocity before_;
  double elapsed_, share_;
  Vec3 start_center_, center_;  // [m] c_0, c~
  Quaternion orientation_;      // R~
  Mat3 inertia_;                // [kg m^2] I~
};

}  // namespace feltwire

#pragma once

#include "core/bounding/split.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// Spring, damper and tool of one port (translation, or rotation with the units in brackets).
template <class Real>
struct Coupling {
  Real stiffness = 0;  // k [N/m] [N m/rad]
  Real damping = 0;    // b_c [N s/m] [N m s/rad]
  Real mass = 0;       // m [kg] [kg m^2], > 0
};

/// mode `virtual_coupling`: the hand holds a simulated tool by a spring and a damper, and only the
/// tool touches the scene. With s = x_device - x_tool, backward Euler:
///   m (v_t(n) - v_t(n-1)) / h = f_e + g,   g = k s(n) + b_c (s(n) - s(n-1)) / h,   f(n) = -g
/// f_e is the scene's force at the tool, probe(). The passivity condition, checked at construction,
/// is
///   b >= k T / 2 + b_c
/// Then delivered <= burned + work of the scene on the tool, for every hand
/// (docs/bounding.md, "virtual_coupling").
/// Sources: J. E. Colgate, M. C. Stanley, J. M. Brown, "Issues in the haptic display of tool use",
/// IROS 1995; R. J. Adams, B. Hannaford, "Stable haptic interaction with virtual environments",
/// IEEE Trans. Robotics and Automation 15(3), 1999; the condition: Colgate & Schenkel, "Passivity
/// of a class of sampled-data systems", J. Robotic Systems 14(1), 1997. Known weakness: every
/// contact feels as soft as the coupling, and free space as heavy as the tool. Nothing pays for a
/// scene that is not passive itself (delay), for a hold longer than T, or for a device that holds
/// less than g. The only admissible reduction of its force is to drop it whole: then the tool jumps
/// to the device.
template <class Real>
class VirtualCoupling {
 public:
  VirtualCoupling(const Coupling<Real>& translation, const Coupling<Real>& rotation, bool torque)
      : translation_{translation}, rotation_{rotation}, torque_(torque) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    const Vector3<Real> force = -translation_.pull(s.command.force(), s.displacement, s.hold_time);
    BasicCommand<Real> rendered = split_along(force, s.command.elastic);
    if (torque_) rendered.torque = -rotation_.pull(s.command.torque, s.rotation, s.hold_time);
    return rendered;
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    if (held.force().isZero(0)) translation_.let_go();
    if (held.torque.isZero(0)) rotation_.let_go();
  }

  /// Returns the place of the tool while the device has moved by `displacement`, `rotation` since
  /// the last step. Small angles: rotation vectors are added.
  BasicProbe<Real> probe(const Vector3<Real>& displacement,
                         const Vector3<Real>& rotation) const noexcept {
    return {-translation_.stretch - displacement, -rotation_.stretch - rotation};
  }

 private:
  struct Port {
    Coupling<Real> law;
    Vector3<Real> stretch = Vector3<Real>::Zero();   // s
    Vector3<Real> velocity = Vector3<Real>::Zero();  // of the tool

    /// Moves the tool and returns g.
    Vector3<Real> pull(const Vector3<Real>& scene, const Vector3<Real>& dx, Real h) noexcept {
      const Vector3<Real> impulse =
          law.mass * velocity + h * (scene + law.stiffness * (stretch + dx)) + law.damping * dx;
      velocity = impulse / (law.mass + h * law.damping + h * h * law.stiffness);
      const Vector3<Real> stretched = dx - h * velocity;
      stretch += stretched;
      return law.stiffness * stretch + (law.damping / h) * stretched;
    }
    void let_go() noexcept {
      stretch.setZero();
      velocity.setZero();
    }
  };

  Port translation_, rotation_;
  bool torque_;
};

}  // namespace feltwire

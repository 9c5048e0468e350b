#pragma once
// Passivity observer and passivity controller (PO/PC): the controller adds damping when the
// observer has seen energy come out.

#include <algorithm>
#include <array>
#include <cmath>
#include <limits>

#include "core/bounding/bounding_config.hpp"
#include "core/bounding/frame.hpp"
#include "core/bounding/split.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// The energy that flowed into one port, W [J], and its reference. Flows have the paper's sign,
/// F.dx > 0 into the controller.
///
/// zero       W(n) = W(n-1) + F(n).dx(n), as published, with what the controller dissipated; must
///           not fall below 0. For a sampled spring this sum is always positive
///            (docs/lab/figures.md): it sees only energy that a delay or an active environment
///            makes.
/// following  W(n) = W(n-1) + F(n-1).dx(n), the real exchange under the zero-order hold; must not
///            fall below the reference E(n) = E(n-1) + 1/2 (F_e(n-1) + F_e(n)).dx(n), which is
///            1/2 k x^2 for a spring, at every sampling rate.
template <class Real>
class PassivityObserver {
 public:
  explicit PassivityObserver(PassivityReference reference = PassivityReference::zero)
      : following_(reference == PassivityReference::following) {}

  /// `commanded` = F_e(n).dx(n), `commanded_before` = F_e(n-1).dx(n), `held` = F(n-1).dx(n) [J].
  /// Returns the energy [J] that is missing, >= 0.
  Real observe(Real commanded, Real commanded_before, Real held) noexcept {
    before_ = energy_;
    energy_ += following_ ? held : commanded;
    if (following_) {
      before_ = energy_;
      wanted_ += (commanded_before + commanded) / 2;
    }
    return std::max(Real(0), wanted_ - energy_);
  }
  /// F(n).dx(n) of the force that is really held from now on.
  void settle(Real flow) noexcept {
    if (!following_) energy_ = before_ + flow;
  }
  /// Adds energy that was dissipated elsewhere.
  void add(Real dissipated) noexcept {
    energy_ += dissipated;
    before_ += dissipated;
  }
  Real energy() const noexcept { return energy_; }

 private:
  bool following_;
  Real energy_ = 0, before_ = 0, wanted_ = 0;
};

/// The input of a controller: one port, force or torque.
template <class Real>
struct PassivityPort {
  PassivityReference reference = PassivityReference::zero;
  Real max = std::numeric_limits<Real>::infinity();  // [N] of the device
  Real slope = 0;                                    // b/T [N/m]

  /// Returns the part of a command that the device can render. Only that part is observed.
  /// Otherwise energy that no motor could take in would be missing for ever.
  Vector3<Real> possible(const Vector3<Real>& command) const noexcept {
    return command.squaredNorm() <= max * max
               ? command
               : Vector3<Real>(reduction(max, length(command)) * command);
  }

  /// The damper's force: energy over movement.
  /// zero       As published. For almost no movement it grows without limit; the device's limit
  ///            comes after.
  /// following  alpha <= b, because the damper is sampled itself and no stiffer one is passive
  ///            (Colgate): its force is constant while the hand turns round, and without a limit
  ///            each encoder step to and fro would require a larger one.
  Real damper_force(Real energy, Real movement) const noexcept {
    constexpr Real kLargest = Real(1e12);  // [N]
    const Real most = reference == PassivityReference::following
                          ? std::min(kLargest, slope * std::abs(movement))
                          : kLargest;
    return std::clamp(energy / movement, -most, most);
  }
};

/// Three axes of a port, each with its own observer.
template <class Real>
struct PassivityAxes {
  PassivityPort<Real> port;
  std::array<PassivityObserver<Real>, 3> axis;
  Vector3<Real> commanded = Vector3<Real>::Zero(), held = Vector3<Real>::Zero();  // F(n-1)
  Vector3<Real> moved = Vector3<Real>::Zero();                                    // dx(n)

  explicit PassivityAxes(const PassivityPort<Real>& of) : port(of) {
    axis.fill(PassivityObserver<Real>(port.reference));
  }
  /// Missing energy by axis; `command` is F_e(n).
  Vector3<Real> observe(const Vector3<Real>& command, const Vector3<Real>& dx) noexcept {
    Vector3<Real> missing;
    for (int i = 0; i < 3; ++i)
      missing[i] = at(i).observe(command[i] * dx[i], commanded[i] * dx[i], held[i] * dx[i]);
    commanded = command;
    moved = dx;
    return missing;
  }
  void settle(const Vector3<Real>& now_held) noexcept {
    held = now_held;
    for (int i = 0; i < 3; ++i) at(i).settle(held[i] * moved[i]);
  }
  PassivityObserver<Real>& at(int i) noexcept { return axis[static_cast<std::size_t>(i)]; }
};

/// mode `passivity_control`: one port an axis, the controller in series (impedance causality:
/// movement in, force out). Missing energy W is dissipated by a damper at once:
///   F(n) = F_e(n) + alpha dx(n)/T,   alpha = W T / dx(n)^2      so that F dx grows by W
/// Source: B. Hannaford, J.-H. Ryu, "Time-domain passivity control of haptic interfaces", IEEE
/// Trans. Robotics and Automation 18(1), 2002; `following`: J.-H. Ryu, C. Preusche, B. Hannaford,
/// G. Hirzinger, "Time domain passivity control with reference energy following", IEEE Trans.
/// Control Systems Technology 13(5), 2005.
/// Known weakness: it acts after the energy is out. Energy gathered before (friction, damping)
/// hides an oscillation for long. At small velocities the damper's force W/dx is an impulse. The
/// direction bends, because each axis acts alone. It bounds no magnitude: a force made smaller
/// dissipates less.
template <class Real>
class PassivityControl {
 public:
  PassivityControl(const PassivityPort<Real>& force, const PassivityPort<Real>& torque,
                   bool torque_on)
      : force_(force), rotation_(torque), torque_on_(torque_on) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    const Vector3<Real> force = -damped(force_, -s.command.force(), s.displacement);
    BasicCommand<Real> rendered = split_along(force, s.command.elastic);
    if (torque_on_) rendered.torque = -damped(rotation_, -s.command.torque, s.rotation);
    return rendered;
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    force_.settle(-held.force());
    rotation_.settle(-held.torque);
  }

 private:
  static Vector3<Real> damped(PassivityAxes<Real>& axes, const Vector3<Real>& command,
                              const Vector3<Real>& dx) noexcept {
    const Vector3<Real> missing = axes.observe(axes.port.possible(command), dx);
    Vector3<Real> force = command;
    for (int i = 0; i < 3; ++i)
      if (missing[i] > 0 && dx[i] != 0) force[i] += axes.port.damper_force(missing[i], dx[i]);
    axes.settle(force);
    return force;
  }

  PassivityAxes<Real> force_, rotation_;
  bool torque_on_;
};

/// mode `passivity_control_parallel`: the controller in parallel (admittance causality). The
/// missing energy W is taken from the movement instead of added to the force:
///   dx_e = dx - alpha F T,   alpha = W / (T F^2)
/// So the environment is moved less than the hand. A device that takes a force cannot move the
/// hand. So here the point at which the scene is asked moves against the force (probe()), by at
/// most the device's own movement a sample; it comes back when the contact ends.
///
/// Source: Hannaford & Ryu 2002, as above. The scene must be asked at probe().
///
/// Known weakness: position drift while in contact, one sample late. Only the environment repays
/// the energy that the hand already got.
template <class Real>
class PassivityControlParallel {
 public:
  PassivityControlParallel(const PassivityPort<Real>& force, const PassivityPort<Real>& torque,
                           bool torque_on)
      : force_(force), rotation_(torque), torque_on_(torque_on) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    hold_back(force_, -s.command.force(), s.displacement, probe_.offset);
    if (torque_on_) hold_back(rotation_, -s.command.torque, s.rotation, probe_.rotation);
    return s.command;
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    force_.settle(-held.force());
    rotation_.settle(-held.torque);
  }
  BasicProbe<Real> probe(const Vector3<Real>&, const Vector3<Real>&) const noexcept {
    return probe_;
  }

 private:
  static void hold_back(PassivityAxes<Real>& axes, const Vector3<Real>& wanted,
                        const Vector3<Real>& dx, Vector3<Real>& offset) noexcept {
    const Vector3<Real> command = axes.port.possible(wanted);
    const Vector3<Real> missing = axes.observe(command, dx);
    axes.settle(command);
    if (command.isZero(0)) offset.setZero();
    for (int i = 0; i < 3; ++i) {
      if (!(missing[i] > 0) || command[i] == 0) continue;
      const Real most = std::abs(dx[i]);
      const Real shift = -std::clamp(missing[i] / command[i], -most, most);
      offset[i] += shift;
      axes.at(i).add(-shift * command[i]);
    }
  }

  PassivityAxes<Real> force_, rotation_;
  bool torque_on_;
  BasicProbe<Real> probe_;
};

/// mode `passivity_control_directional`: one observer for all degrees of freedom, dampers along the
/// directions of force and torque, so that both keep their direction. Missing energy W is shared by
/// what each exchanged, w_f : w_t = |F_e.dx| : |tau_e.dtheta|, and
///   F(n) = F_e(n) + (W_f / (u.dx)) u,   u = F_e / |F_e|         the same for torque
/// Source: C. Preusche, G. Hirzinger, J.-H. Ryu, B. Hannaford, "Time domain passivity control for
/// 6 degrees of freedom haptic displays", IROS 2003.
/// Known weakness: as passivity_control. One observer for all directions lets friction on one pay
/// for oscillation on another.
template <class Real>
class PassivityControlDirectional {
 public:
  PassivityControlDirectional(const PassivityPort<Real>& force, const PassivityPort<Real>& torque,
                              bool torque_on)
      : force_port_(force),
        torque_port_(torque),
        observer_(force.reference),
        torque_on_(torque_on) {}

  BasicCommand<Real> step(const BasicBoundingStep<Real>& s) noexcept {
    moved_ = s.displacement;
    turned_ = s.rotation;
    Vector3<Real> force = s.command.force(), torque = s.command.torque;
    const Vector3<Real> possible_force = force_port_.possible(force);
    const Vector3<Real> possible_torque = torque_port_.possible(torque);
    const Real by_force = -possible_force.dot(moved_), by_torque = -possible_torque.dot(turned_);
    const Real missing = observer_.observe(by_force + by_torque, flow(commanded_), flow(held_));
    if (missing > 0) {
      const Vector3<Real> u = direction(force), v = direction(torque);
      const Real along_u = u.dot(moved_), along_v = v.dot(turned_);
      const Real exchanged = std::abs(by_force) + std::abs(by_torque);
      const Real share = exchanged > 0 ? std::abs(by_force) / exchanged : Real(0);
      if (along_u != 0) force -= force_port_.damper_force(share * missing, along_u) * u;
      if (along_v != 0) torque -= torque_port_.damper_force((1 - share) * missing, along_v) * v;
    }
    commanded_ = {possible_force, Vector3<Real>::Zero(), possible_torque};
    BasicCommand<Real> rendered = split_along(force, s.command.elastic);
    if (torque_on_) rendered.torque = torque;
    set_held(rendered);
    return rendered;
  }
  void set_held(const BasicCommand<Real>& held) noexcept {
    held_ = held;
    observer_.settle(flow(held));
  }

 private:
  Real flow(const BasicCommand<Real>& c) const noexcept {
    return -c.force().dot(moved_) - c.torque.dot(turned_);
  }

  PassivityPort<Real> force_port_, torque_port_;
  PassivityObserver<Real> observer_;
  bool torque_on_;
  BasicCommand<Real> commanded_,
      held_;  // in force and torque; the split of the first does not matter
  Vector3<Real> moved_ = Vector3<Real>::Zero(), turned_ = Vector3<Real>::Zero();
};

}  // namespace feltwire

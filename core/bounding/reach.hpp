#pragma once
// How far the handle of a device can move within the next sample, whatever hand holds it.

#include <limits>

#include "core/base/types.hpp"
#include "core/device/damping.hpp"

namespace feltwire {

/// Certain knowledge of one port (translation or rotation) of a device, and of the forces that act
/// on it from outside. Every lower bound may be smaller and every upper bound larger than the
/// truth: that costs force, never passivity. Units are those of translation; for rotation read rad,
/// N m, kg m^2.
struct PortKnowledge {
  Damping damping{};              // B [N s/m] lower bound of the device's own viscous damping
  double coulomb_friction = 0.0;  // f_c [N] lower bound of the device's own dry friction
  double quantum = 0.0;           // q [m] encoder quantum, of each world axis
  /// m [kg] lower bound of the handle's apparent mass in every direction: the least eigenvalue of
  /// its matrix. 0: unknown, then a hand may move the handle any distance within a sample.
  double mass = 0.0;
  /// F_h [N] upper bound of the force from outside: the hand, gravity that is not compensated, and
  /// what the mechanics of the handle push from one direction into another.
  double outside_force = std::numeric_limits<double>::infinity();
  /// v [m/s] upper bound of the handle's speed, of which nothing else need be known.
  double speed = std::numeric_limits<double>::infinity();
};

/// Throws std::invalid_argument that begins with `field` and names the remedy.
void validate(const PortKnowledge& port, const char* field);

/// The largest displacement along a direction that the encoder can show for the next sample, from
/// the last one and from the forces that act.
///
/// Along the unit vector u, over a sample of h0 that has passed and one of h that begins:
///
///   reach = max(0, G0 h0 h, (u.dx + q1) h/h0 + G0 h0 h/2) + max(0, G) h^2/2 + q1
///   G0 = (f(n-1).u + F_h) / m,   G = (f(n).u + F_h) / m,   q1 = q |u|_1
///
/// docs/bounding.md, "How far the next sample reaches", has the proof. It holds for every friction
/// and damping that oppose the velocity, known or not.
class Reach {
 public:
  /// Precondition: validate(known) passed.
  explicit Reach(const PortKnowledge& known) : known_(known) {}

  /// The handle moved by `displacement` over `hold_time` > 0 [s] while `held` acted. `period` [s]
  /// is what a sample normally takes: samples shorter than half of it are looked at together,
  /// because an encoder shows no speed over a short time.
  void moved(const Vec3& displacement, const Vec3& held, double hold_time, double period) noexcept;
  /// Nothing is known of the handle's speed any more.
  void forget() noexcept { time_ = 0.0; }

  /// Whether the mass and the force from outside are known: else no displacement is bounded.
  bool bounds() const noexcept {
    return known_.mass > 0.0 && known_.outside_force < std::numeric_limits<double>::infinity();
  }
  /// Whether anything bounds the next displacement.
  bool known() const noexcept { return time_ > 0.0 && bounds(); }
  /// A smaller or larger bound of the force from outside [N].
  void set_outside_force(double force) noexcept { known_.outside_force = force; }
  /// [m] along the unit vector u over `hold_time` [s], of a handle that is no faster than was told.
  double at_full_speed(const Vec3& u, double hold_time) const noexcept {
    return known_.speed * hold_time + known_.quantum * u.lpNorm<1>();
  }
  /// [m] along the unit vector u over the next `hold_time` [s], with the component `force` [N]
  /// along u held meanwhile. Precondition: known().
  double along(const Vec3& u, double force, double hold_time) const noexcept;
  /// [m/N] how much each newton of `force` adds to that.
  double per_newton(double hold_time) const noexcept {
    return hold_time * hold_time / (2.0 * known_.mass);
  }

 private:
  PortKnowledge known_;
  // The last movement that says something about the speed.
  Vec3 displacement_ = Vec3::Zero();  // [m]
  Vec3 held_ = Vec3::Zero();          // [N] meanwhile
  double time_ = 0.0;                 // [s] 0: not known
  double strongest_ = 0.0;            // [N] the largest force held meanwhile, of joined samples
  bool joined_ = false;               // several samples together
};

}  // namespace feltwire

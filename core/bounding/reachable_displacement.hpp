#pragma once
// The largest displacement of a device's handle within the next sample, for every hand.

#include <algorithm>
#include <array>
#include <cmath>
#include <cstddef>
#include <limits>
#include <span>

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
  /// the force that the handle's mechanics transfer from one direction into another.
  double outside_force = std::numeric_limits<double>::infinity();
  /// v [m/s] upper bound of the handle's speed. Nothing else need be known of it.
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
/// and damping that oppose the velocity, known or not. "After a tick that is late" there has what
/// the samples before the last one add where that one was longer or shorter than a period.
class ReachableDisplacement {
 public:
  /// Precondition: validate(known) passed.
  explicit ReachableDisplacement(const PortKnowledge& known)
      : known_(known), per_mass_(1.0 / known.mass) {}

  /// The handle moved by `displacement` over `hold_time` > 0 [s] while `held` acted. `period` [s]
  /// is the normal duration of a sample: samples shorter than half of it are joined, because an
  /// encoder shows no speed over a short time. `strongest` [N]: any force up to this one may
  /// have acted for a part of the time, along any direction; below 0: only `held` did.
  void moved(const Vec3& displacement, const Vec3& held, double hold_time, double period,
             double strongest = -1.0) noexcept;
  /// The handle's speed is no longer known.
  void forget() noexcept { past_.fill({}); }

  /// Whether the mass and the force from outside are known; otherwise no displacement is bounded.
  bool bounds() const noexcept {
    return known_.mass > 0.0 && known_.outside_force < std::numeric_limits<double>::infinity();
  }
  /// Whether anything bounds the next displacement.
  bool known() const noexcept { return last().time > 0.0 && bounds(); }
  /// A smaller or larger bound of the force from outside [N].
  void set_outside_force(double force) noexcept { known_.outside_force = force; }

  // Along a vector v of any length: |v| times the displacement along v / |v|. For a force v that is
  // the most energy [J] that the force gives over the displacement. `length` is |v|.

  /// Over `hold_time` [s], of a handle no faster than specified.
  double at_full_speed(const Vec3& v, double length, double hold_time) const noexcept {
    return known_.speed * hold_time * length + known_.quantum * v.lpNorm<1>();
  }
  /// Over the next `hold_time` [s], with `held` [N] held meanwhile. Precondition: known().
  double along(const Vec3& v, double length, const Vec3& held, double hold_time) const noexcept {
    return reached(v, length, std::max(0.0, held.dot(v) + known_.outside_force * length),
                   hold_time);
  }
  /// As above, with no force held.
  double along(const Vec3& v, double length, double hold_time) const noexcept {
    return reached(v, length, known_.outside_force * length, hold_time);
  }
  /// The part by which a displacement along v is longer for each sample of `hold_time` [s] that
  /// comes before it, in which one of `coming` [N], or a part of it, is held. Precondition:
  /// bounds().
  double driven(const Vec3& v, double length, std::span<const Vec3> coming,
                double hold_time) const noexcept {
    double force = 0.0;
    for (const Vec3& next : coming)
      force += std::max(0.0, next.dot(v)) + known_.outside_force * length;
    return force * per_mass_ * hold_time * hold_time;
  }
  /// Whether a sample of `hold_time` [s] that showed `displacement` is within reach along its own
  /// direction for every held force, because it differs from the sample before by less than the
  /// encoder rounds. False means unknown. It saves a root. Precondition: known().
  bool goes_on(const Vec3& displacement, double hold_time) const noexcept {
    // reach >= (u.dx + q1) h/h0 + q1, and q1 >= q. The rest of q is for rounding.
    constexpr double kMost = 0.95;
    const Past& before = last();
    const double rounded = kMost * known_.quantum * (hold_time + before.time);
    return (before.time * displacement - hold_time * before.displacement).squaredNorm() <
               rounded * rounded &&
           before.held.squaredNorm() <= known_.outside_force * known_.outside_force &&
           before.time >= (1.0 - kUsual) * period_;
  }
  /// [m/N] the increase of that for each newton of `force`.
  double per_newton(double hold_time) const noexcept {
    return 0.5 * per_mass_ * hold_time * hold_time;
  }

 private:
  /// A share of a period: a sample that is longer or shorter by more is irregular.
  static constexpr double kUsual = 0.02;
  static constexpr double kOnTime = 1e-9;  // of a period: off by no more than a clock's rounding

  /// A sample that shows a speed: the movement, what was held meanwhile, for how long.
  struct Past {
    Vec3 displacement = Vec3::Zero();  // [m]
    Vec3 held = Vec3::Zero();          // [N]
    double time = 0.0;                 // [s] 0: not known
    double strongest = 0.0;            // [N] the largest held force, of joined samples
    bool joined = false;               // several samples together

    /// |v| times the largest force along v.
    double along(const Vec3& v, double length) const noexcept {
      return joined ? strongest * length : held.dot(v);
    }
    double magnitude() const noexcept;
  };
  const Past& last() const noexcept { return past_[newest_]; }
  /// The samples before it, from age 1 on.
  const Past& past(std::size_t age) const noexcept {
    return past_[(newest_ + past_.size() - age) % past_.size()];
  }
  static Past together(const Past& first, const Past& second) noexcept;

  double reached(const Vec3& v, double length, double force, double hold_time) const noexcept {
    const Past& before = last();
    const double quantum = known_.quantum * v.lpNorm<1>();
    const double held = before.along(v, length) + known_.outside_force * length;
    const double per_newton = per_mass_ * hold_time;
    const double from_rest = held * per_newton * before.time;
    const double longer = hold_time == before.time ? 1.0 : hold_time / before.time;
    const double carried_on = (before.displacement.dot(v) + quantum) * longer + 0.5 * from_rest;
    const double most = std::max(std::max(0.0, from_rest), carried_on);
    const bool on_time = std::abs(before.time - period_) <= kOnTime * period_;
    return (on_time ? most : hold_time * irregular(v, length, most / hold_time)) +
           0.5 * force * per_newton * hold_time + quantum;
  }
  double irregular(const Vec3& v, double length, double simple) const noexcept;
  double fastest(const Past& sample, std::size_t before, const Vec3& v,
                 double length) const noexcept;

  PortKnowledge known_;
  double per_mass_;      // 1/m [1/kg]
  double period_ = 0.0;  // T [s]
  std::array<Past, 3> past_;
  std::size_t newest_ = 0;
};

}  // namespace feltwire

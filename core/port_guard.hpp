#pragma once
// The last line of a hand whose forces are bounded elsewhere: never more than its device has
// burned.

#include "core/bounding/metric.hpp"
#include "core/types.hpp"

namespace feltwire {

/// A force f held over T can give the hand at most f' B^-1 f T / 4 beyond what the device burns
/// meanwhile (dx = B^-1 f T / 2, docs/bounding.md). So a port that has burned E more than it
/// delivered keeps delivered <= burned, whatever the hand does and whoever made the force, while
///   f' B^-1 f T / 4 + tau' B_r^-1 tau T / 4 <= E
/// A command that asks for more is scaled down, force and torque alike. Only a hold longer than T
/// can overdraw that; what it owes is in E from then on.
///
/// This is not a bound to feel by: it lets an oscillation live on what friction and damping
/// gathered before (core/bounding/total_energy.hpp). It is for what must not happen.
class PortGuard {
 public:
  /// Damping [N s/m], [N m s/rad], T [s].
  PortGuard(const Damping& damping, const Damping& rotational_damping, double period)
      : force_(damping), torque_(rotational_damping), quarter_period_(0.25 * period) {}

  /// Whether the device's damping says anything: every direction has some.
  static bool usable(const Damping& damping) { return damping.least() > 0.0; }

  /// What may be held, with `energy` E [J]. Torque without damping is none.
  Command apply(const Command& command, double energy) const noexcept;

 private:
  Metric<double> force_, torque_;
  double quarter_period_;
};

}  // namespace feltwire

#pragma once
// The port guard: the last check at the client, which keeps the energy delivered to the hand at
// most what its device has burned.

#include "core/base/types.hpp"
#include "core/bounding/metric.hpp"

namespace feltwire {

/// A force f held over h can give the hand at most f' B^-1 f h / 4 beyond what the device burns
/// meanwhile (dx = B^-1 f h / 2, docs/bounding.md). So a port that has burned E more than it
/// delivered keeps delivered <= burned, for every hand and every force, while
///   f' B^-1 f h / 4 + tau' B_r^-1 tau h / 4 <= E
/// A command that asks for more is scaled down, force and torque alike. Only a hold longer than the
/// assumed h (HoldReserve) can overdraw that; its debt is in E from then on.
///
/// This is not a bound for normal use: an oscillation may live on the energy that friction and
/// damping burned earlier (core/bounding/total_energy.hpp). It is the last safeguard.
class PortGuard {
 public:
  /// Damping [N s/m], [N m s/rad], of the device alone.
  PortGuard(const Damping& damping, const Damping& rotational_damping)
      : force_(damping), torque_(rotational_damping) {}

  /// Whether the guard can work: every direction of the device is damped.
  static bool usable(const Damping& damping) { return damping.least() > 0.0; }

  /// The command that may be held over `hold_time` h [s], with `energy` E [J]. Without rotational
  /// damping the torque is zero.
  Command apply(const Command& command, double energy, double hold_time) const noexcept;

  /// [J] the left side above: the most energy that a command can give to the hand.
  double needed(const Command& command, double hold_time) const noexcept;

 private:
  Metric<double> force_, torque_;
};

/// The time for which the force of this tick is assumed to be held. The next tick may be late, so
/// it is T plus twice the largest lateness of the last second or two, at most 2 T. A tick that is a
/// whole period late is an overrun, whose debt the port repays.
class HoldReserve {
 public:
  /// T [s].
  explicit HoldReserve(double period) : period_(period) {}

  /// Tells how long the last force was held [s].
  void saw(double hold_time) noexcept;
  double hold_time() const noexcept;  // [s]

 private:
  static constexpr double kWindow = 1.0;  // [s] the longest is forgotten after one or two of these
  double period_;
  double over_ = 0.0, over_before_ = 0.0;  // [s] the most beyond T, in this window and the last
  double window_ = 0.0;                    // [s] of this one so far
};

}  // namespace feltwire

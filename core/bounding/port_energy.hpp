#pragma once
// The observer of what really crosses a haptic port. It bounds nothing; it is how every claim of
// passivity is checked.

#include <cstdint>

#include "core/base/types.hpp"
#include "core/device/damping.hpp"

namespace feltwire {

/// Energy by the part of the command that carried it.
struct ChannelEnergy {
  double elastic = 0.0;     // [J]
  double frictional = 0.0;  // [J]
  double torque = 0.0;      // [J]
  double total() const { return elastic + frictional + torque; }
};

/// Accounts, sample by sample, the energy that held forces delivered to the hand, f(n-1) . dx(n),
/// against what the device's own damping B burned at least, dx' B dx / h over a hold of h. A port
/// whose bound holds never delivers more than that, whatever the hand does: delivered <= burned. A
/// sample after which this is broken, beyond rounding, is a violation.
class PortEnergy {
 public:
  /// damping [N s/m], rotational_damping [N m s/rad], period T [s] (shorter holds count as T).
  /// `rounding`: what a violation has to exceed, relative to all energy exchanged; sums of 1e8
  /// samples in double stay well below the default.
  PortEnergy(const Damping& damping, const Damping& rotational_damping, double period,
             double rounding = 1e-9);

  /// The device moved by `displacement` [m], `rotation` [rad] over `hold_time` [s] while `held`
  /// acted on the hand. A sample with anything not finite, products included, is left out and
  /// counted in `refused`.
  void step(const Command& held, const Vec3& displacement, const Vec3& rotation,
            double hold_time) noexcept;

  const ChannelEnergy& delivered() const { return delivered_; }  // to the hand so far
  double burned() const { return burned_; }  // [J] by the device's damping, at least
  double margin() const { return burned_ - delivered_.total(); }  // [J]
  /// [J] minimum over time of burned - delivered
  double least_margin() const { return least_margin_; }
  std::uint64_t violations() const { return violations_; }
  std::uint64_t refused() const { return refused_; }

 private:
  Damping damping_, rotational_damping_;
  double period_, rounding_;
  ChannelEnergy delivered_;
  double burned_ = 0.0;
  double exchanged_ = 0.0;  // [J] sum of magnitudes: the scale that rounding is measured against
  double least_margin_ = 0.0;
  std::uint64_t violations_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace feltwire

#pragma once
// The monitor of the energy that crosses a haptic port. It bounds nothing. It checks every claim
// of passivity.

#include <cstdint>

#include "core/base/types.hpp"
#include "core/bounding/path_lower_bound.hpp"
#include "core/device/damping.hpp"

namespace feltwire {

/// Energy by the part of the command that carried it.
struct ChannelEnergy {
  double elastic = 0.0;     // [J]
  double frictional = 0.0;  // [J]
  double torque = 0.0;      // [J]
  double total() const { return elastic + frictional + torque; }
};

/// A lower bound of a device's dry friction [N], and the quantum of its encoder [m], by which the
/// path is certain (core/bounding/path_lower_bound.hpp).
struct DryFriction {
  double force = 0.0, quantum = 0.0;
};

/// Compares two energies at each sample: the energy f(n-1) . dx(n) that held forces gave to the
/// hand, and a lower bound of the energy that the device burned: by its damping B, dx' B dx / h in
/// a hold of h, and by its dry friction if that is known. A working bound keeps delivered <= burned
/// for every hand. A sample after which this does not hold, beyond rounding, is a
/// violation.
class PortEnergy {
 public:
  /// damping [N s/m], rotational_damping [N m s/rad], period T [s] (shorter holds count as T).
  /// `rounding`: a violation must exceed this share of all energy exchanged. Sums of 1e8 samples in
  /// double stay well below the default.
  PortEnergy(const Damping& damping, const Damping& rotational_damping, double period,
             const DryFriction& friction = {}, double rounding = 1e-9);

  /// The device moved by `displacement` [m], `rotation` [rad] over `hold_time` [s] while `held`
  /// acted on the hand. A sample in which a number or a product is not finite is left out and
  /// counted in `refused`.
  void step(const Command& held, const Vec3& displacement, const Vec3& rotation,
            double hold_time) noexcept;

  /// From now on the dry friction counts with this force [N].
  void count_friction(double force) noexcept { friction_ = force; }

  const ChannelEnergy& delivered() const { return delivered_; }   // to the hand so far
  double burned() const { return burned_; }                       // [J] by the device, at least
  double margin() const { return burned_ - delivered_.total(); }  // [J]
  /// [J] minimum over time of burned - delivered
  double least_margin() const { return least_margin_; }
  std::uint64_t violations() const { return violations_; }
  std::uint64_t refused() const { return refused_; }

 private:
  Damping damping_, rotational_damping_;
  double period_, rounding_, friction_;
  PathLowerBound path_;
  ChannelEnergy delivered_;
  double burned_ = 0.0;
  double exchanged_ = 0.0;  // [J] sum of magnitudes: the scale that rounding is measured against
  double least_margin_ = 0.0;
  std::uint64_t violations_ = 0;
  std::uint64_t refused_ = 0;
};

}  // namespace feltwire

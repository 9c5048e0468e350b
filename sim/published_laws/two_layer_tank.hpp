#pragma once

#include <algorithm>

#include "core/base/numeric.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// The master's passivity layer of the two-layer approach: a tank of energy H, filled by the energy
/// that the hand puts in, and emptied by the energy that it gets. A force that the tank does not
/// pay for is cut, and while the tank is below its level H_d a damper makes the hand fill it.
///   H(n) = H(n-1) - f(n-1).dx(n)                     f on the hand, the exact energy of a hold
///   |f_e(n)| <= H(n) / |dx(n)|, and 0 where H(n) <= 0    what the tank pays for at this speed
///   f(n) = f_e(n) - d(n) dx(n) / T,   d(n) = alpha (H_d - H(n)) while below H_d, else 0
/// Source: M. Franken, S. Stramigioli, S. Misra, C. Secchi, A. Macchelli, "Bilateral
/// telemanipulation with time delays: a two-layer approach combining passivity and transparency",
/// IEEE Trans. Robotics 27(4), 2011.
/// Taken: the tank, the exact energy of a hold, the limit by the tank at the present velocity, and
/// the tank level controller.
/// Left open there, decided here: H_d = 5 mJ; d is at most half of the device's damping b, reached
/// with an empty tank; the further limit that the source offers, any function of the tank's level,
/// is not used. The environment is virtual: it sends no energy back, so there is one tank and no
/// transfer between two sides.
class TwoLayerTank {
 public:
  static constexpr double kLevel = 5e-3;  // H_d [J]

  TwoLayerTank(double damping, double period) : most_damping_(0.5 * damping), period_(period) {}

  Command step(const BoundingStep& s) noexcept {
    level_ -= held_.dot(s.displacement);
    const double wanted = s.command.force().norm(), moved = s.displacement.norm();
    double share = level_ > 0.0 ? 1.0 : 0.0;
    if (wanted * moved > level_ && level_ > 0.0) share = level_ / (wanted * moved);
    Command rendered{share * s.command.elastic, share * s.command.frictional, Vec3::Zero()};
    const double empty = std::clamp(1.0 - level_ / kLevel, 0.0, 1.0);
    rendered.frictional -= (most_damping_ * empty / period_) * s.displacement;
    held_ = rendered.force();
    return rendered;
  }
  void set_held(const Command& held) noexcept { held_ = held.force(); }

 private:
  double most_damping_, period_;  // [N s/m], T [s]
  double level_ = 0.0;            // H [J]
  Vec3 held_ = Vec3::Zero();      // f(n-1) [N] on the hand
};

}  // namespace feltwire

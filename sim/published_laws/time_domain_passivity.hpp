#pragma once

#include <algorithm>
#include <cmath>

#include "core/bounding/split.hpp"
#include "core/bounding/step.hpp"

namespace feltwire {

/// Time-domain passivity control with the exact energy of a held force:
///   W(n) = W(n-1) + F(n-1).dx(n)                 what the port took in, F(n-1) as it was rendered
///   F(n) = F_e(n) - W(n)/dx(n)   where W(n) < 0, else F_e(n)
/// Source: J.-H. Ryu, Y. S. Kim, B. Hannaford, "Sampled- and continuous-time passivity and
/// stability of virtual environments", IEEE Trans. Robotics 20(4), 2004; the controller as in
/// B. Hannaford, J.-H. Ryu, "Time-domain passivity control of haptic interfaces", IEEE Trans.
/// Robotics and Automation 18(1), 2002.
/// Taken: the pairing F(n-1) dx(n), which contains the energy of the zero-order hold, and the
/// series damper. Left open there, decided here: one port for each axis of the world frame (the
/// source has one degree of freedom); the damper's force is at most the device's largest; the
/// device's own damping is not counted, as the source observes the environment alone.
///
/// With an allowance E the law acts where W(n) < -E, and dissipates what is missing to -E. That is
/// ours. It stands in for A. Jafari, J.-H. Ryu, "Input-to-state stable approach to release the
/// conservatism of passivity-based stable haptic interaction", ICRA 2015, and A. Jafari, M. Nabeel,
/// J.-H. Ryu, "The input-to-state stable (ISS) approach for stable haptic interaction with virtual
/// environments", IEEE Trans. Robotics 33(4), 2017. Taken from them: only the idea that the energy
/// that comes out need not be none, but must be bounded. Their control law, which limits the force
/// by an analogy with hysteresis, was not at hand, and this is not it.
class TimeDomainPassivity {
 public:
  /// `most` [N] of the device, `allowance` [J] of each axis.
  explicit TimeDomainPassivity(double most, double allowance = 0.0)
      : most_(std::min(most, kLargest)), allowance_(allowance) {}

  Command step(const BoundingStep& s) noexcept {
    Vec3 force = -s.command.force();  // F, the sign of the source
    for (int i = 0; i < 3; ++i) {
      const double dx = s.displacement[i];
      energy_[i] += held_[i] * dx;
      const double missing = -allowance_ - energy_[i];
      if (missing > 0.0 && dx != 0.0) force[i] += std::clamp(missing / dx, -most_, most_);
    }
    held_ = force;
    return split_along<double>(-force, s.command.elastic);
  }
  void set_held(const Command& held) noexcept { held_ = -held.force(); }

 private:
  static constexpr double kLargest = 1e6;  // [N]

  double most_, allowance_;
  Vec3 energy_ = Vec3::Zero(), held_ = Vec3::Zero();  // W [J], F(n-1) [N]
};

}  // namespace feltwire

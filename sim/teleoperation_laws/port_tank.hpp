#pragma once

#include <algorithm>
#include <limits>
#include <span>

namespace feltwire::teleop {

/// The tank at one end of the two-layer approach (two_layer.hpp).
struct PortTank {
  static constexpr double kLevel = 0.3;         // H_d [J], also the first charge
  static constexpr double kShare = 0.01;        // beta
  double level = kLevel, sent = 0.0, seen = 0;  // [J]

  /// Once a sample. `work` [J]: what the port took in. The messages carry as `energy` the total [J]
  /// that the other end has sent; an old total changes nothing.
  template <class Message>
  void exchange(double work, std::span<const Message> arrived) {
    level += work;
    for (const Message& m : arrived) {
      level += std::max(0.0, m.energy - seen);
      seen = std::max(seen, m.energy);
    }
    const double share = kShare * std::max(0.0, level);
    sent += share;
    level -= share;
  }
  /// [N] The largest force that the tank pays for over this way [m] >= 0.
  double most(double way) const {
    if (!(level > 0.0)) return 0.0;
    return way > 0.0 ? level / way : std::numeric_limits<double>::infinity();
  }
};

}  // namespace feltwire::teleop

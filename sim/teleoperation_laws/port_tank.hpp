#pragma once

#include <algorithm>
#include <limits>

namespace feltwire::teleop {

/// The tank at one end of the two-layer approach (two_layer.hpp). Call in each sample add(),
/// receive() for each datagram, and send().
struct PortTank {
  static constexpr double kLevel = 0.3;         // H_d [J], also the first charge
  static constexpr double kShare = 0.01;        // beta
  double level = kLevel, sent = 0.0, seen = 0;  // [J]

  /// `work` [J] that the port took in.
  void add(double work) { level += work; }
  /// `total` [J] that the other end has sent; an old total changes nothing.
  void receive(double total) {
    level += std::max(0.0, total - seen);
    seen = std::max(seen, total);
  }
  void send() {
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

#include "core/port_guard.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {

Command PortGuard::apply(const Command& command, double energy) const noexcept {
  Command given = command;
  if (!(torque_.damping() > 0.0)) given.torque.setZero();
  double needed = force_.force(given.force()).squaredNorm() / force_.damping();
  if (torque_.damping() > 0.0)
    needed += torque_.force(given.torque).squaredNorm() / torque_.damping();
  needed *= quarter_period_;
  const double there = std::max(0.0, energy);
  if (needed <= there) return given;
  return std::sqrt(there / needed) * given;
}

}  // namespace feltwire

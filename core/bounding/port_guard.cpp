#include "core/bounding/port_guard.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {

double PortGuard::needed(const Command& command, double hold_time) const noexcept {
  constexpr double kQuarter = 0.25;
  double per_hold = force_.force(command.force()).squaredNorm() / force_.damping();
  if (torque_.damping() > 0.0)
    per_hold += torque_.force(command.torque).squaredNorm() / torque_.damping();
  return kQuarter * hold_time * per_hold;
}

Command PortGuard::apply(const Command& command, double energy, double hold_time) const noexcept {
  Command given = command;
  if (!(torque_.damping() > 0.0)) given.torque.setZero();
  const double wanted = needed(given, hold_time);
  const double there = std::max(0.0, energy);
  // A bound that stands at its own limit is off by some roundings: it is not scaled for that.
  constexpr double kRounding = 1e-12;
  if (wanted <= there * (1.0 + kRounding)) return given;
  return std::sqrt(there / wanted) * given;
}

void HoldReserve::saw(double hold_time) noexcept {
  over_ = std::max(over_, hold_time - period_);
  window_ += hold_time;
  if (!(window_ >= kWindow)) return;
  over_before_ = over_;
  over_ = window_ = 0.0;
}

double HoldReserve::hold_time() const noexcept {
  return period_ + std::clamp(2.0 * std::max(over_, over_before_), 0.0, period_);
}

}  // namespace feltwire

#include "core/bounding/port_energy.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {

PortEnergy::PortEnergy(const Damping& damping, const Damping& rotational_damping, double period,
                       const DryFriction& friction, double rounding)
    : damping_(damping),
      rotational_damping_(rotational_damping),
      period_(period),
      rounding_(rounding),
      friction_(friction.force),
      path_(friction.quantum) {}

void PortEnergy::step(const Command& held, const Vec3& displacement, const Vec3& rotation,
                      double hold_time) noexcept {
  const double elastic = held.elastic.dot(displacement);
  const double frictional = held.frictional.dot(displacement);
  const double torque = held.torque.dot(rotation);
  const double hold = hold_time > period_ ? hold_time : period_;
  const double burned =
      (damping_.quadratic(displacement) + rotational_damping_.quadratic(rotation)) / hold;
  // This sum is not finite if an input is not finite or a product overflowed.
  const double exchange = std::abs(elastic) + std::abs(frictional) + std::abs(torque) + burned;
  if (!std::isfinite(exchange) || !std::isfinite(hold_time)) {
    ++refused_;
    return;
  }

  delivered_.elastic += elastic;
  delivered_.frictional += frictional;
  delivered_.torque += torque;
  burned_ += burned + friction_ * path_.moved(displacement);
  exchanged_ += exchange;

  least_margin_ = std::min(least_margin_, margin());
  if (margin() < -rounding_ * exchanged_) ++violations_;
}

}  // namespace feltwire

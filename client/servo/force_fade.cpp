#include "client/servo/force_fade.hpp"

#include "core/base/numeric.hpp"

namespace feltwire {

double ForceFade::step(Nanoseconds now, double age, double elapsed, double hold_time) noexcept {
  const double half = 0.5 * hold_time;
  double most = std::clamp((hold_time - age) / half, 0.0, 1.0);
  if (ending_) most = std::clamp(1.0 - seconds(now - from_) / half, 0.0, most);
  silent_ = !(most > 0.0) && !ending_;
  share_ = std::min(most, share_ + std::max(elapsed, 0.0) / half);
  return share_;
}

Command faded(const Command& command, double share, double most_force,
              double most_torque) noexcept {
  if (!(share < 1.0)) return command;
  const double force = length(command.force()), torque = length(command.torque);
  const double of_force = force > most_force ? share * (most_force / force) : share;
  const double of_torque = torque > most_torque ? share * (most_torque / torque) : share;
  return {of_force * command.elastic, of_force * command.frictional, of_torque * command.torque};
}

}  // namespace feltwire

#include "client/run/hold_time.hpp"

#include <algorithm>
#include <cmath>
#include <sstream>
#include <stdexcept>

namespace feltwire {

void choose_hold_time(SessionParameters& parameters, bool follows) {
  constexpr double kRounded = 1e-9;
  const double least = kPeriodsInHoldTime * parameters.servo_period;
  if (!std::isfinite(least) || parameters.hold_time >= (1.0 - kRounded) * least) return;
  if (follows) {
    parameters.hold_time = least;
    return;
  }
  std::ostringstream message;
  message << "--hold-time " << parameters.hold_time << " is too short for a servo period of "
          << parameters.servo_period
          << " s: each force would end before the next tick, and the session with it; give "
             "--hold-time "
          << least << " or more, or --rate " << std::ceil(kPeriodsInHoldTime / parameters.hold_time)
          << " or more where the device does not set it";
  throw std::invalid_argument(message.str());
}

void require_heard(const SessionParameters& p, double silence_timeout) {
  const double interval = p.packet_interval * p.servo_period;
  const double silent = p.position_deadband > 0.0 ? std::max(interval, p.keep_alive) : interval;
  if (silent < silence_timeout) return;
  std::ostringstream message;
  message << "this client sends every " << silent
          << " s, and the server ends a session that says nothing for " << silence_timeout
          << " s; give a higher --rate or a higher packet_rate or shorter keep_alive of "
             "--traffic, or the server a longer --silence-timeout";
  throw std::invalid_argument(message.str());
}

}  // namespace feltwire

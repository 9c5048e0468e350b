#include "server/reply_deadband.hpp"

#include <algorithm>

namespace feltwire {

bool ReplyDeadband::withhold(Reply& reply) noexcept {
  if (!on()) return false;
  reply.predicted = parameters_.predictor == Predictor::linear;
  if (reply.predicted) reply.rates = trend_.rates();
  if (any_ && !differs(reply)) return true;
  any_ = true;
  command_ = reply.command;
  rates_ = reply.rates;
  refused_ = reply.refused;
  saturated_ = reply.saturated;
  since_ = 0.0;
  return false;
}

bool ReplyDeadband::differs(const Reply& reply) const noexcept {
  const SessionParameters& p = parameters_;
  // The next datagram comes an interval later, which would be too late. Half a tick: a servo does
  // not wake up to the nanosecond.
  const double next = (p.packet_interval - 0.5) * p.servo_period;
  if (!(since_ + next < p.keep_alive)) return true;
  if (reply.gap || reply.refused != refused_ || reply.saturated != saturated_) return true;
  const Command known = extrapolated(command_, rates_, std::min(since_, p.keep_alive));
  return beyond_deadband(reply.command, known, p.force_deadband) ||
         acts(reply.command) != acts(command_);
}

}  // namespace feltwire

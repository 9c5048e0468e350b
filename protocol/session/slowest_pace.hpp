#pragma once
// How far apart a server that is short of time may ask for datagrams (PROTOCOL.md).

#include <algorithm>

#include "protocol/session/session_parameters.hpp"

namespace feltwire {

/// The most packet intervals between two datagrams of a session, at least one: 10 ms and a quarter
/// of the hold time, so that answers reach the hand while it holds the last one.
inline int slowest_pace(const SessionParameters& parameters) noexcept {
  constexpr double kLongest = 0.01;  // [s]
  constexpr double kShareOfHold = 0.25, kRounding = 1.0 + 1e-9;
  const double longest = std::min(kLongest, kShareOfHold * parameters.hold_time);
  const double interval = parameters.packet_interval * parameters.servo_period;
  return std::max(1, static_cast<int>(kRounding * longest / interval));
}

}  // namespace feltwire

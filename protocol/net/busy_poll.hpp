#pragma once
// The time for which a thread polls for datagrams before it sleeps.

#include <cmath>

#include "protocol/wire/datagram.hpp"

namespace feltwire {

/// A time longer than any run of a program.
inline constexpr Nanoseconds kForever = Nanoseconds::max();
inline constexpr double kLongestBusyPoll = 1e6;  // [us] short of infinity, which is for ever

/// 0 to kLongestBusyPoll, or infinity.
inline bool possible_busy_poll(double microseconds) {
  return (microseconds >= 0.0 && microseconds <= kLongestBusyPoll) || microseconds == HUGE_VAL;
}

/// Precondition: possible.
inline Nanoseconds busy_poll_time(double microseconds) {
  constexpr double kOfMicrosecond = 1e3;  // [ns]
  return std::isinf(microseconds) ? kForever
                                  : Nanoseconds(std::llround(microseconds * kOfMicrosecond));
}

}  // namespace feltwire

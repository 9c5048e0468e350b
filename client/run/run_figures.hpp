#pragma once
// The measurements of a run with which `feltwire-client --check` judges the machine and the
// network.

#include <cstdint>
#include <optional>

#include "client/servo/servo_loop.hpp"
#include "client/transport/control_client.hpp"
#include "core/base/histogram.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {

struct RunFigures {
  EndReason end = EndReason::failed;
  double duration = 0.0;                       // [s] from the first tick to the last
  double servo_period = 0.0, hold_time = 0.0;  // [s] as granted
  std::uint64_t samples = 0;                   // ticks that were made
  std::uint64_t missed_deadlines = 0;          // ticks that were missed
  Histogram wakeup_late;                       // [ns] each tick behind its deadline
  std::uint64_t datagrams = 0;                 // datagrams with samples
  std::uint64_t lost = 0;                      // of these, or their replies
  std::uint64_t too_long = 0;                  // of these, too long for the path
  std::uint64_t shortened = 0;                 // replies that were shortened for the path
  Histogram round_trip;                        // [ns]
  std::optional<double> jitter{};              // [s] mean variation of the delay, the worse way
  RealTime real_time;
  Address server;  // of the datagrams
};

}  // namespace feltwire

#pragma once
// Whether a device ticks as a session needs it: `feltwire-client devices --rate KIND`.

#include <cstdint>
#include <vector>

#include "client/device/device.hpp"
#include "client/run/check_result.hpp"
#include "core/base/histogram.hpp"
#include "protocol/net/real_time.hpp"

namespace feltwire {

/// The ticks of a device while nothing is on the hand.
struct DeviceTicks {
  double span = 0.0;          // [s]
  double longest_tick = 0.0;  // [s] that the device guarantees; 0: the servo's timer sets the pace
  std::uint64_t ticks = 0, missed = 0;  // missed: none came within 25 ms
  std::uint64_t overlong = 0;           // ticks longer than the longest that is guaranteed
  std::uint64_t repeated = 0;           // readings that were not new
  std::uint64_t faults = 0;
  Histogram interval{};  // [ns] from one tick to the next
  RealTime real_time{};
};

/// Ticks as the servo does, for `span` [s] in a thread of its own, and puts no force on the hand.
/// `rate` [Hz] is for a device that sets no pace.
DeviceTicks watch_ticks(Device& device, double span, double rate);

/// Judges each of: rate, jitter, longest tick, readings, faults, permissions.
std::vector<CheckResult> judge(const DeviceTicks& ticks);

}  // namespace feltwire

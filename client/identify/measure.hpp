#pragma once
// Runs an identification on a device, by the clock or at the device's own tick.

#include <atomic>
#include <cstdint>

#include "client/devices/device.hpp"
#include "client/identify/identification.hpp"

namespace feltwire {

/// The state of a measurement that other threads may read while it runs.
struct MeasureStatus {
  std::atomic<bool> stop{false};        // set it: the force goes, and it ends
  std::atomic<double> progress{0.0};    // 0..1
  std::atomic<int> sweep{-1};           // axis or diagonal, in the plan's order; -1: none
  std::atomic<std::int64_t> ticked{0};  // [ns] monotonic time of the last tick; 0: none yet
  std::atomic<bool> over{false};
};

/// [s] of a device that sets no pace.
inline constexpr double kMeasurePeriod = 1e-3;

/// Ticks until the identification is over, then releases the device. Neither allocates nor throws.
void measure(Device& device, Identification& identification, MeasureStatus& status) noexcept;

/// Releases the device where measure() makes no tick for the time that one may be late, because the
/// device's library hangs. Returns when it is over (true), or when it did not end within a second
/// after that (false): then the program should end without much ado.
bool watch(Device& device, MeasureStatus& status) noexcept;

}  // namespace feltwire

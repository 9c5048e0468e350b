#pragma once
// Runs an identification on a device, by the clock or at the device's own tick.

#include <atomic>
#include <cstdint>

#include "client/devices/device.hpp"
#include "client/identify/identification.hpp"

namespace feltwire {

/// The state of a measurement that other threads may read while it runs.
struct MeasureStatus {
  std::atomic<bool> stop{false};        // set it to end: the force becomes zero
  std::atomic<double> progress{0.0};    // 0..1
  std::atomic<int> sweep{-1};           // axis or diagonal, in the plan's order; -1: none
  std::atomic<std::int64_t> ticked{0};  // [ns] monotonic time of the last tick; 0: none yet
  std::atomic<bool> over{false};
};

/// [s] for a device that sets no pace.
inline constexpr double kMeasurePeriod = 1e-3;

/// Ticks until the identification is over, then releases the device. It neither allocates nor
/// throws.
void measure(Device& device, Identification& identification, MeasureStatus& status) noexcept;

/// Releases the device if measure() makes no tick for the allowed lateness, because the device's
/// library hangs. Returns true when it is over. Returns false if it did not end within a second
/// after that: then the program should end at once.
bool watch(Device& device, MeasureStatus& status) noexcept;

}  // namespace feltwire

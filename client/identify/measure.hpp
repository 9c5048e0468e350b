#pragma once
// Runs an identification on a device, by the clock or at the device's own tick.

#include <atomic>
#include <cstdint>
#include <functional>
#include <optional>
#include <string_view>

#include "client/device/device.hpp"
#include "client/identify/identification.hpp"

namespace feltwire {

/// The state of a measurement that other threads may read while it runs.
struct MeasureStatus {
  std::atomic<bool> stop{false};        // set it to end: the force becomes zero
  std::atomic<double> progress{0.0};    // 0..1
  std::atomic<int> sweep{-1};           // axis or diagonal, in the plan's order; -1: none
  std::atomic<std::int64_t> ticked{0};  // [ns] monotonic time of the last tick; 0: none yet
  std::atomic<const char*> awaits{""};  // why it cannot begin yet, with the remedy
  std::atomic<bool> over{false};
};

/// [s] for a device that sets no pace.
inline constexpr double kMeasurePeriod = 1e-3;

/// Asks the device until it is ready for force (Device::prepare()), and gives each new text of what
/// a person must do to `tell`. Throws std::runtime_error with the last text after `patience`.
void await_prepared(Device& device, Nanoseconds patience,
                    const std::function<void(std::string_view)>& tell);

/// An identification on a device, tick by tick. It begins when the device has taken forces for a
/// fifth of a second without a fault: before, nothing is on the hand. It is given up if the device
/// has a fault for 5 s or withholds forces for 60 s before the begin, and at once afterwards.
class Measurement {
 public:
  /// References are kept.
  Measurement(Device& device, Identification& identification, MeasureStatus& status)
      : device_(device), identification_(identification), status_(status) {}

  /// After the wait for a tick of the device. `came`: it came. `now` rises. It neither allocates
  /// nor throws.
  void tick(Nanoseconds now, bool came) noexcept;

 private:
  bool ready(const DeviceReading* reading, Nanoseconds now) noexcept;

  Device& device_;
  Identification& identification_;
  MeasureStatus& status_;
  bool began_ = false;
  std::optional<Nanoseconds> faulty_since_, withheld_since_, usable_since_;
};

/// Ticks until the identification is over, then releases the device. It neither allocates nor
/// throws.
void measure(Device& device, Identification& identification, MeasureStatus& status) noexcept;

/// Releases the device if measure() makes no tick for the allowed lateness, because the device's
/// library hangs. Returns true when it is over. Returns false if it did not end within a second
/// after that: then the program should end at once.
bool watch(Device& device, MeasureStatus& status) noexcept;

}  // namespace feltwire

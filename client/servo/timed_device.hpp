#pragma once
// A device whose calls are timed: one that blocks makes every tick late, and should be known for
// it.

#include <algorithm>
#include <cstdint>
#include <utility>

#include "client/device/device.hpp"
#include "core/base/histogram.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {

/// The time that the calls of a device take [ns].
struct DeviceTimes {
  Histogram read, write;
  std::uint64_t slow = 0;  // ticks in which both together took more than half a servo period
};

/// For the servo thread. It measures read(), and the write() after it. No clock and no histogram
/// allocates.
class TimedDevice final : public Device {
 public:
  /// `times` must outlive this.
  TimedDevice(Device& device, Nanoseconds period, DeviceTimes& times)
      : device_(device), period_(period), times_(times) {}

  const DeviceSpec& spec() const override { return device_.spec(); }
  double motion_scale() const override { return device_.motion_scale(); }
  Nanoseconds longest_tick() const override { return device_.longest_tick(); }
  bool await_tick(Nanoseconds latest) noexcept override { return device_.await_tick(latest); }
  DeviceReading read(Nanoseconds now) noexcept override {
    const Nanoseconds begun = monotonic_now();
    DeviceReading reading = device_.read(now);
    read_ = monotonic_now() - begun;
    times_.read.record(read_.count());
    took(read_);
    return reading;
  }
  Command write(const Command& on_hand) noexcept override {
    const Nanoseconds begun = monotonic_now();
    Command held = device_.write(on_hand);
    const Nanoseconds wrote = monotonic_now() - begun;
    times_.write.record(wrote.count());
    // A slow read() was counted.
    if (2 * read_ <= period_) took(read_ + wrote);
    longest_ = std::max(longest_, read_ + wrote);
    return held;
  }
  bool lower_tool(Nanoseconds now) noexcept override { return device_.lower_tool(now); }
  void release() noexcept override { device_.release(); }

  /// The longest tick since the last call.
  Nanoseconds take_longest() noexcept { return std::exchange(longest_, Nanoseconds(0)); }

 private:
  void took(Nanoseconds time) noexcept {
    times_.slow += 2 * time > period_ ? 1 : 0;
    longest_ = std::max(longest_, time);
  }

  Device& device_;
  Nanoseconds period_;
  DeviceTimes& times_;
  Nanoseconds read_{0}, longest_{0};
};

}  // namespace feltwire

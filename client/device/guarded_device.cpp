#include "client/device/guarded_device.hpp"

#include <unistd.h>

namespace feltwire {

void GuardedDevice::leave() noexcept {
  call_.store(DeviceCall::none, std::memory_order_release);
  calls_.fetch_add(1, std::memory_order_release);
  Where expected = Where::in_device;
  if (where_.compare_exchange_strong(expected, Where::outside)) return;
  while (true) ::pause();  // this thread stays blocked, because other threads use its data now
}

bool GuardedDevice::abandon() noexcept {
  Where expected = Where::in_device;
  return where_.compare_exchange_strong(expected, Where::abandoned);
}

bool GuardedDevice::await_tick(Nanoseconds latest) noexcept {
  if (released()) return true;  // read() then reports the end of the device
  enter(DeviceCall::await_tick);
  const bool came = device_.await_tick(latest);
  leave();
  return came;
}

DeviceReading GuardedDevice::read(Nanoseconds now) noexcept {
  if (released()) return {.pose = {}, .ok = false, .ended = true};
  tick_.store(now, std::memory_order_release);
  enter(DeviceCall::read);
  DeviceReading reading = device_.read(now);
  leave();
  if (released()) reading.ok = false, reading.ended = true;
  return reading;
}

Command GuardedDevice::write(const Command& on_hand) noexcept {
  Command held;
  if (!released()) {
    enter(DeviceCall::write);
    const bool pulls = !on_hand.force().isZero(0.0) || !on_hand.torque.isZero(0.0);
    if (pulls) pulls_.store(true);
    held = device_.write(on_hand);
    if (!pulls) pulls_.store(false);  // the device held the last force until this write
    // Another thread may have released the device before this write. A second release() undoes the
    // write.
    if (released()) {
      device_.release();
      held = {};
    }
    leave();
  }
  writes_.fetch_add(1, std::memory_order_release);
  return held;
}

bool GuardedDevice::lower_tool(Nanoseconds now) noexcept {
  if (released()) return true;
  enter(DeviceCall::lower_tool);
  const bool lowered = device_.lower_tool(now);
  leave();
  return lowered;
}

void GuardedDevice::release() noexcept {
  released_.store(true);
  device_.release();
}

}  // namespace feltwire

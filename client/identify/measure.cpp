#include "client/identify/measure.hpp"

#include <chrono>
#include <thread>

#include "client/devices/tick_pace.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr Nanoseconds kPatience = std::chrono::milliseconds(50);
constexpr Nanoseconds kHung = std::chrono::milliseconds(100);
constexpr Nanoseconds kGivenUp = std::chrono::seconds(1);

double in_seconds(Nanoseconds time) { return std::chrono::duration<double>(time).count(); }

void tick(Device& device, Identification& identification, Nanoseconds now) noexcept {
  const DeviceReading reading = device.read(now);
  if (!reading.ok || reading.ended)
    identification.give_up("the device has a fault");
  else if (!reading.fresh)
    return;  // the force goes on being held
  // The device knows better than write() did what it held since the last reading.
  if (reading.held) identification.held(reading.held->force());
  const Vec3 force = identification.step(in_seconds(now), reading.pose.position);
  const Command held = device.write({.elastic = force});
  identification.held(held.force());
}

}  // namespace

void measure(Device& device, Identification& identification, MeasureStatus& status) noexcept {
  TickPace pace(device, from_seconds(kMeasurePeriod));
  while (identification.state() == Identification::State::measuring) {
    if (!pace.wait(kPatience)) identification.give_up("the device does not tick");
    if (status.stop.load()) identification.give_up("it was asked to stop");
    const Nanoseconds now = monotonic_now();
    tick(device, identification, now);
    status.ticked.store(now.count());
    status.progress.store(identification.progress());
    status.sweep.store(identification.line());
  }
  device.release();
  status.over.store(true);
}

bool watch(Device& device, MeasureStatus& status) noexcept {
  bool released = false;
  Nanoseconds since{0};
  while (!status.over.load()) {
    std::this_thread::sleep_for(kHung / 10);
    const Nanoseconds now = monotonic_now(), last(status.ticked.load());
    if (released && now - since > kGivenUp) return status.over.load();
    if (last.count() == 0 || now - last < kHung || released) continue;
    device.release();
    status.stop.store(true);
    released = true;
    since = now;
  }
  return true;
}

}  // namespace feltwire

#include "client/identify/measure.hpp"

#include <chrono>
#include <stdexcept>
#include <string>
#include <thread>

#include "client/device/await_prepared.hpp"
#include "client/device/tick_pace.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr Nanoseconds kPatience = std::chrono::milliseconds(50);
constexpr Nanoseconds kHung = std::chrono::milliseconds(100);
constexpr Nanoseconds kGivenUp = std::chrono::seconds(1);
// Pause between two checks of the device.
constexpr Nanoseconds kBetween = std::chrono::milliseconds(10);
// Limits before the start: longest fault, longest wait for a person, and the time for which the
// device must be usable without a break.
constexpr Nanoseconds kLongestFault = std::chrono::seconds(5);
constexpr Nanoseconds kLongestWithheld = std::chrono::seconds(60);
constexpr Nanoseconds kUsable = std::chrono::milliseconds(200);

/// Returns why the device gives no force, and the remedy. Returns an empty text if it gives force.
const char* remedy(const DeviceReading* reading) noexcept {
  if (reading == nullptr || !reading->ok || reading->ended)
    return "the device has a fault; see its cable, power and calibration";
  switch (reading->withheld) {
    case Withheld::not_homed:
      return "the device is not homed; move its handle all the way out, and all the way in";
    case Withheld::in_inkwell:
      return "the stylus is in its inkwell; take it out, and let it hang freely";
    case Withheld::starting:
      return "the maker's library raises its force to the full; wait";
    case Withheld::not_moved:
      return "the program that moves the hand gives no position";
    case Withheld::emergency:
      return "the emergency stop was pressed; reset it";
    case Withheld::nothing:
      break;
  }
  return "";
}

/// Returns how long `so` has been true. `since` is empty while `so` is false.
Nanoseconds lasted(bool so, Nanoseconds now, std::optional<Nanoseconds>& since) noexcept {
  if (!so) since.reset();
  if (so && !since) since = now;
  return so ? now - *since : Nanoseconds(0);
}

}  // namespace

void await_prepared(Device& device, Nanoseconds patience,
                    const std::function<void(std::string_view)>& tell) {
  const Nanoseconds latest = monotonic_now() + patience;
  await_prepared(device, tell, [&](const std::string& wanted) {
    if (monotonic_now() > latest)
      throw std::runtime_error("the device was not made ready in time: " + wanted);
    std::this_thread::sleep_for(kBetween);
    return true;
  });
}

/// Returns whether the device has been usable long enough to start. Gives up after a long fault or
/// a long wait. `reading`: null if the device gave no reading.
bool Measurement::ready(const DeviceReading* reading, Nanoseconds now) noexcept {
  const bool faulty = reading == nullptr || !reading->ok || reading->ended;
  const bool withheld = !faulty && reading->withheld != Withheld::nothing;
  const bool usable = !faulty && !withheld;
  const char* why = remedy(reading);
  const bool given_up = lasted(faulty, now, faulty_since_) > kLongestFault ||
                        lasted(withheld, now, withheld_since_) > kLongestWithheld;
  began_ = lasted(usable, now, usable_since_) >= kUsable;
  status_.awaits.store(why);
  if (given_up) identification_.give_up(why);
  return began_;
}

void Measurement::tick(Nanoseconds now, bool came) noexcept {
  if (status_.stop.load()) identification_.give_up("it was asked to stop");
  if (!came && began_) identification_.give_up("the device does not tick");
  DeviceReading reading;
  if (came) reading = device_.read(now);
  if (came && reading.ok && !reading.fresh) return;  // the device continues to hold the force
  if (!began_ && !ready(came ? &reading : nullptr, now)) {
    if (came) device_.write({});
    return;
  }
  if (const char* why = came ? remedy(&reading) : ""; *why != '\0') identification_.give_up(why);
  // The reading reports the held force more exactly than write().
  if (reading.held) identification_.held(reading.held->force());
  const Vec3 force = identification_.step(seconds(now), reading.pose.position);
  const Command held = device_.write({.elastic = force});
  identification_.held(held.force());
}

void measure(Device& device, Identification& identification, MeasureStatus& status) noexcept {
  TickPace pace(device, from_seconds(kMeasurePeriod));
  Measurement measurement(device, identification, status);
  while (identification.state() == Identification::State::measuring) {
    const bool came = pace.wait(kPatience);
    const Nanoseconds now = monotonic_now();
    measurement.tick(now, came);
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

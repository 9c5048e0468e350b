#include "client/run/device_check.hpp"

#include <algorithm>
#include <thread>

#include "client/device/tick_pace.hpp"
#include "core/base/units.hpp"
#include "protocol/net/clock.hpp"

namespace feltwire {
namespace {

constexpr Nanoseconds kTickPatience = std::chrono::milliseconds(25);
constexpr double kPerSecond = 1e9;  // nanoseconds per second

const char* const kCalmMachine =
    "end other programs, connect the device without a hub, and give the client the rights of "
    "docs/devices.md (real-time scheduling)";

void tick_until(Device& device, Nanoseconds end, Nanoseconds period, DeviceTicks& told) {
  const Nanoseconds longest = device.longest_tick();
  constexpr Nanoseconds kNone{-1};
  Nanoseconds last = kNone;
  TickPace pace(device, period);
  while (monotonic_now() < end) {
    const bool came = pace.wait(kTickPatience);
    const Nanoseconds now = monotonic_now();
    if (!came) {
      ++told.missed;
      last = kNone;
      continue;
    }
    const DeviceReading reading = device.read(now);
    if (reading.ok && !reading.fresh)
      ++told.repeated;
    else
      device.write({});
    ++told.ticks;
    told.faults += reading.ok ? 0 : 1;
    if (last != kNone) {
      told.interval.record((now - last).count());
      told.overlong += longest > Nanoseconds(0) && now - last > longest ? 1 : 0;
    }
    last = now;
  }
}

double share(std::uint64_t part, std::uint64_t whole) {
  return whole > 0 ? static_cast<double>(part) / static_cast<double>(whole) : 1.0;
}

std::string milliseconds(double nanoseconds) {
  return figure(kMilli * nanoseconds / kPerSecond, 2) + " ms";
}

CheckResult rate(const DeviceTicks& t) {
  constexpr double kPasses = 0.0, kWorks = 0.01;  // limits of the share of missed ticks
  return check_result("rate", rising(share(t.missed, t.ticks + t.missed), kPasses, kWorks),
                      figure(t.span > 0.0 ? static_cast<double>(t.ticks) / t.span : 0.0, 1) +
                          " ticks a second, " + std::to_string(t.missed) + " missed",
                      std::string("see that the device is on and calibrated; ") + kCalmMachine);
}

CheckResult jitter(const DeviceTicks& t) {
  // Limits of the spread, relative to the usual interval.
  constexpr double kPasses = 0.2, kWorks = 1.0;
  const double half = t.interval.quantile(0.5), most = t.interval.quantile(0.99);
  const double spread = half > 0.0 ? (most - half) / half : kWorks + 1.0;
  return check_result("jitter", rising(spread, kPasses, kWorks),
                      "half within " + milliseconds(half) + ", 99 % within " + milliseconds(most) +
                          ", the longest " + milliseconds(static_cast<double>(t.interval.max())),
                      kCalmMachine);
}

CheckResult longest(const DeviceTicks& t) {
  constexpr double kPasses = 0.001, kWorks = 0.05;  // limits of the share of overlong ticks
  return check_result("longest tick", rising(share(t.overlong, t.ticks), kPasses, kWorks),
                      std::to_string(t.overlong) + " of " + std::to_string(t.ticks) +
                          " ticks longer than the " + milliseconds(kPerSecond * t.longest_tick) +
                          " that the driver counts on",
                      kCalmMachine);
}

CheckResult readings(const DeviceTicks& t) {
  constexpr double kPasses = 0.01, kWorks = 0.5;  // limits of the share of repeated readings
  const std::uint64_t fresh = t.ticks - std::min(t.repeated, t.ticks);
  const double fresh_rate = t.span > 0.0 ? static_cast<double>(fresh) / t.span : 0.0;
  return check_result(
      "readings", rising(share(t.repeated, t.ticks), kPasses, kWorks),
      figure(fresh_rate, 1) + " new ones a second",
      "--rate " + figure(fresh_rate, 0) + " for the session: a faster servo gains nothing");
}

CheckResult faults(const DeviceTicks& t) {
  return check_result(
      "faults", t.faults == 0 && t.ticks > 0 ? Verdict::pass : Verdict::fail,
      std::to_string(t.faults) + " of " + std::to_string(t.ticks) + " readings",
      "see the device's cable, power and calibration; docs/devices.md says what each "
      "driver takes for a fault");
}

}  // namespace

DeviceTicks watch_ticks(Device& device, double span, double rate) {
  DeviceTicks told;
  told.longest_tick = seconds(device.longest_tick());
  std::thread servo([&] {
    told.real_time = request_real_time(kServoPriority);
    const Nanoseconds begin = monotonic_now();
    tick_until(device, begin + from_seconds(span), from_seconds(1.0 / rate), told);
    told.span = seconds(monotonic_now() - begin);
  });
  servo.join();
  device.release();
  return told;
}

std::vector<CheckResult> judge(const DeviceTicks& ticks) {
  std::vector<CheckResult> results = {rate(ticks), jitter(ticks)};
  if (ticks.longest_tick > 0.0) results.push_back(longest(ticks));
  results.push_back(readings(ticks));
  results.push_back(faults(ticks));
  results.push_back(permissions(ticks.real_time));
  return results;
}

}  // namespace feltwire

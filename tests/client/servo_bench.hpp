#pragma once
// A servo for tests: parameters, replies and readings.

#include <cmath>
#include <limits>
#include <string>

#include "client/servo/servo.hpp"

namespace feltwire::testing::servo {

inline constexpr double kNan = std::numeric_limits<double>::quiet_NaN();
inline constexpr double kInfinity = std::numeric_limits<double>::infinity();
inline constexpr Nanoseconds kPeriod = std::chrono::milliseconds(1);

inline Nanoseconds seconds(double s) { return Nanoseconds(std::llround(s * 1e9)); }

inline SessionParameters parameters(std::string_view mode,
                                    BoundingSide side = BoundingSide::client) {
  SessionParameters p;
  p.mode = mode;
  p.side = side;
  return p;
}

inline Reply reply(std::uint64_t index, const Command& command) {
  Reply r;
  r.sample_index = index;
  r.command = command;
  return r;
}
inline Command elastic(double x, double y, double z) { return {.elastic = Vec3(x, y, z)}; }
inline DeviceReading at(double x, double y, double z) {
  return {.pose = {.position = Vec3(x, y, z)}};
}
/// As at(), but the driver vouches for the reading: the test moves farther than a hand can.
inline DeviceReading surely_at(double x, double y, double z) {
  DeviceReading reading = at(x, y, z);
  reading.jumped = false;
  return reading;
}

/// The usual device without a known mass; the account then counts on none.
inline DeviceSpec without_known_mass(const std::string& device = "simulated") {
  DeviceSpec spec = builtin_device(device);
  spec.least_mass = spec.rotation.least_inertia = spec.rotation.hand_torque = 0.0;
  return spec;
}

/// A servo whose device holds each given force, ticked every period.
struct Bench {
  DeviceSpec spec = builtin_device("simulated");
  Servo servo;
  Nanoseconds now = seconds(100.0);

  explicit Bench(const SessionParameters& p, const ServoOptions& options = {})
      : servo(spec, p, options) {}
  Bench(const SessionParameters& p, const DeviceSpec& device) : spec(device), servo(spec, p) {}

  Command tick(const DeviceReading& reading = {}, Nanoseconds after = kPeriod) {
    now += after;
    const Command given = servo.render(reading, now);
    servo.hold(given);
    return given;
  }
};

}  // namespace feltwire::testing::servo

#pragma once
// A session of a servo with a device, in virtual time or at the device's own ticks: a wall answers
// each sample some ticks later.

#include <gtest/gtest.h>

#include <cstdio>
#include <cstdlib>
#include <deque>
#include <numbers>
#include <string>
#include <thread>
#include <utility>

#include "client/servo/servo.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/session/session_parameters.hpp"
#include "tests/devices/force_edge.hpp"

namespace feltwire::testing {

struct WallSession {
  double stiffness = 2000.0;  // [N/m] of z < 0
  double twist = 0.0;         // [N m/rad] of turns about z, below a quarter of a turn
  std::size_t delay = 20;     // ticks there and back
  double period;              // [s] that a tick takes

  /// Ticks once. False: the device's tick did not come.
  bool tick(Device& device, Servo& servo) {
    now += from_seconds(period);
    const bool came = device.longest_tick().count() == 0 || device.await_tick(now);
    const Sample* sample = came ? servo.tick(device, now) : servo.missed_tick(device, now);
    if (sample != nullptr) {
      Reply& reply = on_the_way.emplace_back();
      reply.sample_index = sample->index;
      reply.client_time = sample->client_time;
      reply.command.elastic.z() = stiffness * std::max(0.0, -sample->pose.position.z());
      const Quaternion& q = sample->pose.orientation;
      reply.command.torque.z() =
          twist * std::max(0.0, std::numbers::pi / 2 - 2.0 * std::atan2(q.z(), q.w()));
    }
    if (on_the_way.size() > delay) {
      servo.take(on_the_way.front(), now);
      on_the_way.pop_front();
    }
    return came;
  }

  /// Ticks for `time` [s].
  void run(Device& device, Servo& servo, double time) {
    for (double t = 0.0; t < time; t += period) tick(device, servo);
  }

  Nanoseconds now = std::chrono::seconds(7);
  std::deque<Reply> on_the_way{};
};

/// [s] that a session in real time lasts: `usual`, or FELTWIRE_SESSION_SECONDS, with which a table
/// is measured (docs/devices.md).
inline double session_seconds(double usual) {
  const char* asked = std::getenv("FELTWIRE_SESSION_SECONDS");
  return asked != nullptr ? std::atof(asked) : usual;
}
inline bool measures() { return std::getenv("FELTWIRE_SESSION_SECONDS") != nullptr; }

/// The force has gone within the hold time and a tick after the fault, by the stand-in's own ticks
/// and by `waited` [s], what the servo's ticks since then take at most. A busy machine makes both
/// no longer.
inline void expect_in_time(const char* device, const std::string& fault,
                           const stand_in::ForceEdge& edge, double waited) {
  constexpr double kStandInTick = 1e-3;  // [s] of every stand-in
  const double most = SessionParameters{}.hold_time + kStandInTick;
  ASSERT_TRUE(edge.ended());
  EXPECT_LE(kStandInTick * static_cast<double>(edge.ticks()), most);
  EXPECT_LE(waited, most);
  if (measures())
    std::printf("%-14s %-24s %3ld ticks, servo %4.0f ms, by the clock %6.1f ms\n", device,
                fault.c_str(), edge.ticks(), 1e3 * waited, 1e3 * edge.seconds());
}

/// Where another thread lets it go: only the clock can tell. A busy machine may take that many
/// times as long as the hold time, and the test says no more than that it is not forever.
inline void expect_in_time_by_clock(const char* device, const std::string& fault,
                                    const stand_in::ForceEdge& edge) {
  constexpr double kBusy = 50.0;
  ASSERT_TRUE(edge.ended());
  EXPECT_LE(edge.seconds(), kBusy * SessionParameters{}.hold_time);
  if (measures())
    std::printf("%-14s %-24s by the clock %6.1f ms\n", device, fault.c_str(), 1e3 * edge.seconds());
}

/// Of a device that sets the pace with a thread of its own, in real time.
struct PacedSession {
  Vec3 normal = Vec3::UnitZ();                           // of the wall through the origin
  double stiffness = 2000.0;                             // [N/m]
  std::size_t delay = 20;                                // ticks there and back
  Nanoseconds patience = std::chrono::milliseconds(25);  // for a tick

  /// Ticks as run_servo_loop() does, until it holds.
  template <class Until>
  void run(Device& device, Servo& servo, Until until) {
    const Nanoseconds latest = monotonic_now() + from_seconds(120.0 + session_seconds(0.0));
    const Nanoseconds began = monotonic_now();
    while (!until()) {
      lasted = seconds(monotonic_now() - began);
      if (monotonic_now() > latest) return (void)(ADD_FAILURE() << "it has not come to that");
      const bool came = device.await_tick(monotonic_now() + patience);
      ++ticks;
      missed += came ? 0 : 1;
      const Nanoseconds now = monotonic_now();
      const Sample* sample = came ? servo.tick(device, now) : servo.missed_tick(device, now);
      if (sample != nullptr) {
        Reply& reply = on_the_way.emplace_back();
        reply.sample_index = sample->index;
        reply.client_time = sample->client_time;
        const double depth = -normal.dot(sample->pose.position);
        reply.command.elastic = stiffness * std::max(0.0, depth) * normal;
      }
      if (on_the_way.size() <= delay) continue;
      servo.take(on_the_way.front(), now);
      on_the_way.pop_front();
    }
  }

  /// Another thread lets the device go while the servo ticks.
  template <class Until>
  void run_released(Device& device, Servo& servo, Until until) {
    std::thread other([&] { device.release(); });
    run(device, servo, until);
    other.join();
  }

  /// The fault begins now.
  void strike(stand_in::ForceEdge& edge) {
    edge.strike();
    struck = {ticks, missed};
  }
  /// The force is gone.
  void expect_let_go(const char* device, const std::string& fault,
                     const stand_in::ForceEdge& edge) const {
    const auto late = static_cast<double>(missed - struck.second);
    const double came = static_cast<double>(ticks - struck.first) - late;
    expect_in_time(device, fault, edge, 1e-3 * came + seconds(patience) * late);
  }

  /// One line of the table.
  void tell(const char* device, const Servo& servo, double force, double made) const {
    if (!measures()) return;
    const ServoStatistics& s = servo.statistics();
    std::printf("%-14s %6.1f s %8llu ticks %4llu missed %4llu faults %6.2f N %10.2e J made\n",
                device, lasted, static_cast<unsigned long long>(ticks),
                static_cast<unsigned long long>(missed),
                static_cast<unsigned long long>(s.device_faults), force, made);
  }

  std::deque<Reply> on_the_way{};
  std::uint64_t ticks = 0, missed = 0;
  double lasted = 0.0;                               // [s]
  std::pair<std::uint64_t, std::uint64_t> struck{};  // ticks and missed ones until the fault
};

inline SessionParameters session_of(const Device& device) {
  SessionParameters parameters;
  parameters.mode = kSessionMethod;
  if (device.longest_tick().count() > 0) parameters.servo_period = seconds(device.longest_tick());
  return parameters;
}

}  // namespace feltwire::testing

#pragma once
// A session of a servo with a device, in virtual time or at the device's ticks. A wall answers each
// sample some ticks later.

#include <gtest/gtest.h>

#include <atomic>
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

/// [s] duration of a session in real time: `usual`, or FELTWIRE_SESSION_SECONDS for the measurement
/// of a table (docs/devices.md).
inline double session_seconds(double usual) {
  const char* asked = std::getenv("FELTWIRE_SESSION_SECONDS");
  return asked != nullptr ? std::atof(asked) : usual;
}
inline bool measures() { return std::getenv("FELTWIRE_SESSION_SECONDS") != nullptr; }

/// The force must end within the hold time and a tick after the fault. Two times count: the
/// stand-in's own ticks, and `waited` [s], the longest that the servo's ticks since the fault can
/// take. A busy machine lengthens neither.
inline void expect_in_time(const char* device, const std::string& fault,
                           const stand_in::ForceEdge& edge, double waited) {
  constexpr double kStandInTick = 1e-3;  // [s] of each stand-in
  const double most = SessionParameters{}.hold_time + kStandInTick;
  ASSERT_TRUE(edge.ended());
  EXPECT_LE(kStandInTick * static_cast<double>(edge.ticks()), most);
  EXPECT_LE(waited, most);
  if (measures())
    std::printf("%-14s %-24s %3ld ticks, servo %4.0f ms, by the clock %6.1f ms\n", device,
                fault.c_str(), edge.ticks(), 1e3 * waited, 1e3 * edge.seconds());
}

/// Another thread releases the device, so only the clock can measure it. A busy machine may take
/// kBusy times the hold time: the test only shows that the force does end.
inline void expect_in_time_by_clock(const char* device, const std::string& fault,
                                    const stand_in::ForceEdge& edge) {
  constexpr double kBusy = 50.0;
  ASSERT_TRUE(edge.ended());
  EXPECT_LE(edge.seconds(), kBusy * SessionParameters{}.hold_time);
  if (measures())
    std::printf("%-14s %-24s by the clock %6.1f ms\n", device, fault.c_str(), 1e3 * edge.seconds());
}

/// A session of a device that sets the pace with its own thread, in real time.
struct PacedSession {
  Vec3 normal = Vec3::UnitZ();                           // of the wall through the origin
  double stiffness = 2000.0;                             // [N/m]
  std::size_t delay = 20;                                // ticks there and back
  Nanoseconds patience = std::chrono::milliseconds(25);  // for a tick

  /// Ticks as run_servo_loop() does, until `until` is true.
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

  /// Runs while another thread releases the device.
  template <class Until>
  void run_released(Device& device, Servo& servo, Until until) {
    std::thread other([&] { device.release(); });
    run(device, servo, until);
    other.join();
  }

  /// Marks the beginning of the fault.
  void strike(stand_in::ForceEdge& edge) {
    edge.strike();
    struck = {ticks, missed};
  }
  /// Requests a fault of the stand-in by its count `left`, and ticks until the servo has counted a
  /// fault. A late tick can hide a late answer or a jump, so a fault that stays unseen is requested
  /// again.
  void suffer(Device& device, Servo& servo, stand_in::ForceEdge& edge, std::atomic<int>& left) {
    constexpr int kSeenWithin = 3;  // ticks
    const std::uint64_t faults = servo.statistics().device.faults;
    int unseen = kSeenWithin;
    run(device, servo, [&] {
      if (servo.statistics().device.faults > faults) return true;
      unseen = left.load() > 0 ? 0 : unseen + 1;
      if (unseen > kSeenWithin) {
        strike(edge);
        left.store(1);
      }
      return false;
    });
  }
  /// Checks that the force ended in time.
  void expect_let_go(const char* device, const std::string& fault,
                     const stand_in::ForceEdge& edge) const {
    const auto late = static_cast<double>(missed - struck.second);
    const double came = static_cast<double>(ticks - struck.first) - late;
    expect_in_time(device, fault, edge, 1e-3 * came + seconds(patience) * late);
  }

  /// Prints a line of the table.
  void tell(const char* device, const Servo& servo, double force, double made) const {
    if (!measures()) return;
    const ServoStatistics& s = servo.statistics();
    std::printf("%-14s %6.1f s %8llu ticks %4llu missed %4llu faults %6.2f N %10.2e J made\n",
                device, lasted, static_cast<unsigned long long>(ticks),
                static_cast<unsigned long long>(missed),
                static_cast<unsigned long long>(s.device.faults), force, made);
  }

  std::deque<Reply> on_the_way{};
  std::uint64_t ticks = 0, missed = 0;
  double lasted = 0.0;                               // [s]
  std::pair<std::uint64_t, std::uint64_t> struck{};  // ticks and missed ticks at the fault
};

inline SessionParameters session_of(const Device& device) {
  SessionParameters parameters;
  parameters.mode = kSessionMethod;
  if (device.longest_tick().count() > 0) parameters.servo_period = seconds(device.longest_tick());
  return parameters;
}

}  // namespace feltwire::testing

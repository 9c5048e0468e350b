#pragma once
// A session of a servo with a device, in virtual time or at the device's own ticks: a wall answers
// each sample some ticks later.

#include <gtest/gtest.h>

#include <deque>

#include "client/servo/servo.hpp"
#include "protocol/net/clock.hpp"
#include "protocol/session/session_parameters.hpp"

namespace feltwire::testing {

struct WallSession {
  double stiffness = 2000.0;  // [N/m] of z < 0
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

/// Of a device that sets the pace with a thread of its own, in real time.
struct PacedSession {
  Vec3 normal = Vec3::UnitZ();                           // of the wall through the origin
  double stiffness = 2000.0;                             // [N/m]
  std::size_t delay = 20;                                // ticks there and back
  Nanoseconds patience = std::chrono::milliseconds(25);  // for a tick

  /// Ticks as run_servo_loop() does, until it holds.
  template <class Until>
  void run(Device& device, Servo& servo, Until until) {
    const Nanoseconds latest = monotonic_now() + std::chrono::seconds(60);
    while (!until()) {
      if (monotonic_now() > latest) return (void)(ADD_FAILURE() << "it has not come to that");
      const bool came = device.await_tick(monotonic_now() + patience);
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

  std::deque<Reply> on_the_way{};
};

inline SessionParameters session_of(const Device& device) {
  SessionParameters parameters;
  parameters.mode = kSessionMethod;
  if (device.longest_tick().count() > 0) parameters.servo_period = seconds(device.longest_tick());
  return parameters;
}

}  // namespace feltwire::testing

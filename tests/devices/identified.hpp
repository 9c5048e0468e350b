#pragma once
// Measures a free handle of a driver's device as `identify` does, on the stand-in's clock.

#include <gtest/gtest.h>

#include <string>

#include "client/identify/measure.hpp"
#include "protocol/net/clock.hpp"
#include "tests/devices/simulated_mass.hpp"

namespace feltwire::testing {

inline void let_free(stand_in::SimulatedMass& mass) { mass.stiffness = mass.hand_damping = 0.0; }

/// A short travel, which takes a third of the usual time.
inline IdentifyLimits short_way(const DeviceSpec& spec) {
  IdentifyLimits limits = identify_limits(spec);
  limits.amplitude = 0.006;
  limits.travel = 1.6 * limits.amplitude;
  limits.top_speed = 0.12;
  limits.speed = 2.0 * limits.top_speed;
  limits.late = 1e3;  // a busy machine's pause is not the stand-in's time
  return limits;
}

struct Identified {
  explicit Identified(Device& device)
      : spec(device.spec()), identification(spec, short_way(spec), 1e-3) {}

  /// Ticks until `until` or the end. `time` [s] is the stand-in's clock after a tick.
  template <class Time, class Until>
  void run(Device& device, Time time, Until until) {
    Measurement measurement(device, identification, status);
    const bool paced = device.longest_tick() > Nanoseconds(0);
    while (identification.state() == Identification::State::measuring && !until()) {
      const bool came = !paced || device.await_tick(monotonic_now() + std::chrono::seconds(10));
      measurement.tick(from_seconds(time()), came);
    }
  }
  template <class Time>
  void run(Device& device, Time time) {
    run(device, time, [] { return false; });
  }

  /// The reported numbers must be above zero and at most the true ones.
  void expect_below(const stand_in::SimulatedMass& truth) const {
    ASSERT_EQ(identification.state(), Identification::State::done) << identification.why();
    const DeviceEstimate found = identification.estimate();
    ASSERT_TRUE(found.doubts.empty()) << found.doubts.front();
    for (int i = 0; i < spec.translation_dof; ++i) {
      EXPECT_LE(found.damping_bound[i], truth.damping);
      EXPECT_GT(found.damping_bound[i], 0.1 * truth.damping);
    }
    EXPECT_LE(found.friction_bound, truth.friction);
    EXPECT_LE(found.mass_bound, truth.mass);
    EXPECT_GT(found.mass_bound, 0.3 * truth.mass);
  }

  DeviceSpec spec;
  MeasureStatus status;
  Identification identification;
};

}  // namespace feltwire::testing

#pragma once
// Runs a whole identification of a simulated handle.

#include "client/identify/identification.hpp"
#include "tests/client/identify/simulated_handle.hpp"

namespace feltwire::identify_test {

inline constexpr double kPeriod = 1e-3;  // [s]

inline DeviceSpec spec_of(double max_force, int dof = 3) {
  DeviceSpec spec;
  spec.name = "handle";
  spec.translation_dof = dof;
  spec.damping = 0.05;
  spec.apparent_mass = 0.1;
  spec.max_force = spec.continuous_force = max_force;
  spec.workspace = Vec3::Constant(0.16);
  return spec;
}

inline Identification measured(const HandleTruth& truth, const DeviceSpec& spec, double force) {
  Identification identification(spec, identify_limits(spec, force), kPeriod);
  SimulatedHandle handle(truth);
  for (int n = 0; identification.state() == Identification::State::measuring; ++n) {
    const Vec3 on_handle = identification.step(n * kPeriod, handle.read());
    identification.held(on_handle);
    handle.hold(on_handle, kPeriod);
  }
  return identification;
}

}  // namespace feltwire::identify_test

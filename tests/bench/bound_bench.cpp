// bound/METHOD/DOF: one step of a bounding method. The hand slides over a stiff wall.
// account/METHOD/DOF: the method and a session's account, with an equal hand.
// account/METHOD/DOF/cut: the account also reduces every force.

#include <benchmark/benchmark.h>

#include <array>
#include <cmath>
#include <string>

#include "core/bounding/bounding.hpp"
#include "core/bounding/device_account.hpp"

namespace feltwire::bound_bench {
namespace {

constexpr std::size_t kSteps = 1024;  // a lap of the recorded hand; a power of two

/// Returns movements and commands as in a session, made before the clock runs.
std::array<BoundingStep, kSteps> recorded_hand(int dof) {
  std::array<BoundingStep, kSteps> steps;
  for (std::size_t n = 0; n < kSteps; ++n) {
    const double t = 2.0 * M_PI * static_cast<double>(n) / kSteps;
    BoundingStep& s = steps[n];
    s.hold_time = 1e-3;
    s.displacement = {9e-5 * std::cos(t), 4e-5 * std::sin(7.0 * t), 0.0};
    s.command.elastic = {0.0, 3.0 + 2.0 * std::sin(3.0 * t), 0.0};
    s.command.frictional = {-0.9 * std::cos(t), 0.05 * std::sin(7.0 * t), 0.0};
    if (dof == 2) continue;
    s.displacement.z() = 3e-5 * std::sin(2.0 * t);
    s.command.frictional.z() = -0.3 * std::sin(2.0 * t);
    if (dof == 3) continue;
    s.rotation = {1e-4 * std::sin(t), 2e-4 * std::cos(2.0 * t), 1e-4 * std::sin(5.0 * t)};
    s.command.torque = {0.02 * std::sin(t), 0.03, -0.01 * std::cos(t)};
  }
  return steps;
}

BoundingConfig complete(BoundingConfig config, int dof) {
  config.damping = 0.5;
  config.rotational_damping = 1e-3;
  config.rotation = dof == 6;
  config.max_force = 8.9;
  config.max_torque = 0.5;
  return config;
}

void step(benchmark::State& state, const BoundingConfig& incomplete, int dof) {
  const BoundingConfig config = complete(incomplete, dof);
  const auto steps = recorded_hand(dof);
  Bounding bounding(config);
  std::size_t n = 0;
  for (auto _ : state) {
    benchmark::DoNotOptimize(bounding.step(steps[n]));
    n = (n + 1) % kSteps;
  }
}

/// Returns a device with all values for the account: damping, dry friction, encoder, mass and the
/// hand's force.
DeviceSpec known_device(int dof) {
  DeviceSpec spec = builtin_device("simulated");
  spec.damping = 0.5;
  spec.least_friction = 0.03;
  spec.position_resolution = 3e-5;
  spec.least_mass = 0.075;
  spec.hand_force = 10.0;
  spec.max_force = 8.9;
  if (dof < 6) return spec;
  spec.rotation_actuated = 3;
  spec.rotational_damping = 1e-3;
  spec.rotation.resolution = 1e-4;
  spec.rotation.least_inertia = 1e-4;
  spec.rotation.hand_torque = 0.5;
  spec.max_torque = 0.5;
  return spec;
}

/// With `cut` the commands act along the hand's movement. The account then lacks energy and reduces
/// each command.
void step_with_account(benchmark::State& state, const BoundingConfig& incomplete, int dof,
                       bool cut) {
  const BoundingConfig config = complete(incomplete, dof);
  auto steps = recorded_hand(dof);
  for (BoundingStep& s : steps) {
    s.local = true;
    if (!cut) continue;
    s.command = {};
    s.command.elastic = 5.0 * s.displacement.normalized();
    if (dof == 6) s.command.torque = 0.1 * s.rotation.normalized();
  }
  Bounding bounding(config);
  PortAccount account(account_config(known_device(dof), config.period));
  std::size_t n = 0;
  for (auto _ : state) {
    BoundingStep s = steps[n];
    s.command = bounding.step(s).rendered;
    s.command = account.step(s);
    bounding.set_held(s.command);
    benchmark::DoNotOptimize(s.command);
    n = (n + 1) % kSteps;
  }
  state.counters["cut"] =
      static_cast<double>(account.statistics().reduced) / static_cast<double>(state.iterations());
}

[[maybe_unused]] const bool account_registered = [] {
  for (const char* method : {"shaped", "midpoint", "credited", "contact_frame"})
    for (const int dof : {3, 6})
      for (const bool cut : {false, true}) {
        BoundingConfig config;
        config.mode = method;
        config.projection = Projection::cone;
        const std::string name =
            "account/" + std::string(method) + "/" + std::to_string(dof) + (cut ? "/cut" : "");
        benchmark::RegisterBenchmark(name.c_str(), step_with_account, config, dof, cut);
      }
  return true;
}();

[[maybe_unused]] const bool registered = [] {
  for (const std::string_view method : bounding_method_names())
    for (const int dof : {2, 3, 6}) {
      BoundingConfig config;
      config.mode = method;
      config.projection = Projection::cone;
      const std::string name = "bound/" + std::string(method) + "/" + std::to_string(dof);
      benchmark::RegisterBenchmark(name.c_str(), step, config, dof);
      if (config.mode != "contact_frame") continue;
      config.storage = Storage::elastic;
      const std::string elastic = "bound/contact_frame_elastic/" + std::to_string(dof);
      benchmark::RegisterBenchmark(elastic.c_str(), step, config, dof);
    }
  return true;
}();

}  // namespace
}  // namespace feltwire::bound_bench

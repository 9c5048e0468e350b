#include "client/identify/sweep_plan.hpp"

#include <algorithm>
#include <array>
#include <cmath>
#include <numbers>
#include <span>

namespace feltwire {
namespace {

struct Speed {
  double share;  // ratio of the speed to the top speed
  int cycles;    // number of cycles; fast cycles are short, so their end errors weigh more
};
constexpr std::array kSpeeds = {Speed{0.16, 1}, Speed{0.32, 1}, Speed{0.5, 2}, Speed{0.72, 3},
                                Speed{1.0, 5}};

// Frequencies of the vibration. The lowest frequency has three periods per stroke (half a cycle).
// Several frequencies are necessary, because losses other than damping grow with the frequency.
constexpr std::array kShakes = {10.0, 14.0, 20.0, 28.0, kHighestLagShake};  // [Hz]
// The last one is below half the tick rate of a device at 1 kHz.
constexpr std::array kResonances = {56.0, 80.0, 113.0, 160.0, 226.0, 320.0};  // [Hz]
constexpr double kShakenSpeed = 0.5;  // ratio of the sweep speed to the top speed
constexpr int kShakenCycles = 4;      // one cycle for each vibration phase

/// Returns the position within a stroke (half a cycle), from 0 to 1, at the relative time t, from 0
/// to 1.
double way(double t) {
  const double speed = 1.0 / (1.0 - kTurnShare);
  if (t < kTurnShare) return 0.5 * speed * t * t / kTurnShare;
  if (t > 1.0 - kTurnShare) return 1.0 - 0.5 * speed * (1.0 - t) * (1.0 - t) / kTurnShare;
  return speed * (t - 0.5 * kTurnShare);
}

std::vector<Sweep> shaken_at(std::span<const double> frequencies, int dof, double top_speed) {
  std::vector<Sweep> plan;
  plan.reserve(static_cast<std::size_t>(dof) * frequencies.size());
  for (int i = 0; i < dof; ++i)
    for (const double shake : frequencies)
      plan.push_back({Vec3::Unit(i), kShakenSpeed * top_speed, kShakenCycles, shake});
  return plan;
}

}  // namespace

std::vector<Sweep> sweep_plan(int dof, double top_speed) {
  std::vector<Vec3> lines;
  const auto axes = static_cast<std::size_t>(dof);
  lines.reserve(axes * axes);
  for (int i = 0; i < dof; ++i) lines.push_back(Vec3::Unit(i));
  for (int i = 0; i < dof; ++i)
    for (int j = i + 1; j < dof; ++j)
      for (const double sign : {1.0, -1.0})
        lines.push_back((Vec3::Unit(i) + sign * Vec3::Unit(j)).normalized());
  std::vector<Sweep> plan;
  for (const Vec3& line : lines)
    for (const Speed& speed : kSpeeds)
      plan.push_back({line, speed.share * top_speed, speed.cycles});
  return plan;
}

std::vector<Sweep> shaken_plan(int dof, double top_speed) {
  return shaken_at(kShakes, dof, top_speed);
}

std::vector<Sweep> resonance_plan(int dof, double top_speed) {
  return shaken_at(kResonances, dof, top_speed);
}

double shake_phase(int cycle) {
  constexpr std::array kTurns = {0.0, 0.5, 0.25, 0.75};
  return 2.0 * std::numbers::pi * kTurns[static_cast<std::size_t>(cycle) % kTurns.size()];
}

double shake_share(const Sweep& sweep, double amplitude, double time) {
  const double cycle = cycle_time(sweep, amplitude), in_cycle = std::fmod(time, cycle);
  const double of_way = std::fmod(in_cycle, 0.5 * cycle) / (0.5 * cycle);
  const double from_turn = std::min({of_way, 1.0 - of_way, kTurnShare}) / kTurnShare;
  const double soft = 0.5 - 0.5 * std::cos(std::numbers::pi * from_turn);
  const double turned = 2.0 * std::numbers::pi * sweep.shake * in_cycle;
  return soft * std::sin(turned + shake_phase(static_cast<int>(time / cycle)));
}

double cycle_time(const Sweep& sweep, double amplitude) {
  return 2.0 * 2.0 * amplitude / (sweep.speed * (1.0 - kTurnShare));
}

double led_to(const Sweep& sweep, double amplitude, double time) {
  const double half = 0.5 * cycle_time(sweep, amplitude);
  const double phase = std::fmod(time / half, 2.0);
  const double done = phase < 1.0 ? way(phase) : 1.0 - way(phase - 1.0);
  return amplitude * (2.0 * done - 1.0);
}

}  // namespace feltwire

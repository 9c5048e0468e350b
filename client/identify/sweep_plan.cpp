#include "client/identify/sweep_plan.hpp"

#include <array>
#include <cmath>

namespace feltwire {
namespace {

constexpr double kTurn = 0.2;  // of the time of one way, at each end: the speed rises or falls

struct Speed {
  double share;  // of the top speed
  int cycles;    // a fast cycle is short, and its ends weigh more
};
constexpr std::array kSpeeds = {Speed{0.16, 1}, Speed{0.32, 1}, Speed{0.5, 2}, Speed{0.72, 3},
                                Speed{1.0, 5}};

/// Of one way, in units of its length, at the time t in 0..1 of it.
double way(double t) {
  const double speed = 1.0 / (1.0 - kTurn);
  if (t < kTurn) return 0.5 * speed * t * t / kTurn;
  if (t > 1.0 - kTurn) return 1.0 - 0.5 * speed * (1.0 - t) * (1.0 - t) / kTurn;
  return speed * (t - 0.5 * kTurn);
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

double cycle_time(const Sweep& sweep, double amplitude) {
  return 2.0 * 2.0 * amplitude / (sweep.speed * (1.0 - kTurn));
}

double led_to(const Sweep& sweep, double amplitude, double time) {
  const double half = 0.5 * cycle_time(sweep, amplitude);
  const double phase = std::fmod(time / half, 2.0);
  const double done = phase < 1.0 ? way(phase) : 1.0 - way(phase - 1.0);
  return amplitude * (2.0 * done - 1.0);
}

}  // namespace feltwire

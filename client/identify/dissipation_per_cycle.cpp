#include "client/identify/dissipation_per_cycle.hpp"

#include <algorithm>
#include <cmath>

namespace feltwire {
namespace {

/// Interpolates the velocity at `shift` [ticks] after tick k.
class VelocityBetween {
 public:
  VelocityBetween(std::span<const SweepTick> ticks, double shift)
      : ticks_(ticks),
        whole_(static_cast<std::size_t>(shift)),
        part_(shift - std::floor(shift)),
        last_(ticks.size() - kHalfWindow - 1) {}
  Vec3 operator()(std::size_t k) const {
    const std::size_t from = std::clamp(k + whole_, kHalfWindow, last_);
    const std::size_t to = std::min(from + 1, last_);
    return (1.0 - part_) * velocity_at(ticks_, from, kHalfWindow) +
           part_ * velocity_at(ticks_, to, kHalfWindow);
  }

 private:
  std::span<const SweepTick> ticks_;
  std::size_t whole_;
  double part_;
  std::size_t last_;
};

}  // namespace

Vec3 velocity_at(std::span<const SweepTick> ticks, std::size_t k, std::size_t half) {
  const SweepTick &before = ticks[k - half], &after = ticks[k + half];
  return (after.position - before.position) / (after.time - before.time);
}

std::vector<DissipationCycle> dissipation_per_cycle(const SweepRecord& run, double delay,
                                                    double mass) {
  std::vector<DissipationCycle> cycles;
  const std::span<const SweepTick> ticks = run.ticks;
  if (ticks.size() < 4 * kHalfWindow || run.turns.size() < 2) return cycles;
  const double period =
      (ticks.back().time - ticks.front().time) / static_cast<double>(ticks.size() - 1);
  // The device holds a force from one tick to the next, so on average the force acts half a tick
  // later.
  const VelocityBetween velocity(ticks, 0.5 + delay / period);
  for (std::size_t n = 0; n + 1 < run.turns.size(); ++n) {
    const std::size_t first = run.turns[n], end = run.turns[n + 1];
    double work = 0.0, way = 0.0, slow = 0.0, squares = 0.0;
    Vec3 mean_force = Vec3::Zero(), moved = Vec3::Zero();
    for (std::size_t k = first; k < end; ++k) {
      const double span = ticks[k + 1].time - ticks[k].time;
      const Vec3 v = velocity(k);
      work += ticks[k].force.dot(v) * span;
      way += v.norm() * span;
      if (v.norm() < kSlow) slow += v.norm() * span;
      squares += v.squaredNorm() * span;
      moved += v * span;
      mean_force += ticks[k].force / static_cast<double>(end - first);
    }
    if (!(way > 0.0)) continue;
    // Subtract the change of kinetic energy, and the work of the mean force over the displacement
    // that remains at the end of the cycle.
    const double kinetic = velocity(end).squaredNorm() - velocity(first).squaredNorm();
    work -= 0.5 * mass * kinetic + mean_force.dot(moved);
    cycles.push_back({work / way, squares / way, slow / way});
  }
  return cycles;
}

double pull_back(const SweepRecord& run) {
  if (run.turns.size() < 2) return 0.0;
  const std::size_t first = run.turns.front(), end = run.turns.back();
  const double count = static_cast<double>(end - first);
  double x = 0.0, f = 0.0, xx = 0.0, xf = 0.0;
  for (std::size_t k = first; k < end; ++k) {
    x += run.sweep.along.dot(run.ticks[k].position) / count;
    f += run.sweep.along.dot(run.ticks[k].force) / count;
  }
  for (std::size_t k = first; k < end; ++k) {
    const double at = run.sweep.along.dot(run.ticks[k].position) - x;
    xx += at * at;
    xf += at * (run.sweep.along.dot(run.ticks[k].force) - f);
  }
  return xx > 0.0 ? xf / xx : 0.0;
}

FittedLine fitted_line(std::span<const DissipationCycle> cycles) {
  FittedLine line;
  const double count = static_cast<double>(cycles.size());
  line.freedom = static_cast<int>(cycles.size()) - 2;
  if (line.freedom < 1) return line;
  double x = 0.0, y = 0.0, xx = 0.0, xy = 0.0, squares = 0.0;
  for (const DissipationCycle& c : cycles) x += c.speed / count, y += c.resistance / count;
  for (const DissipationCycle& c : cycles) {
    xx += (c.speed - x) * (c.speed - x);
    xy += (c.speed - x) * (c.resistance - y);
  }
  if (!(xx > 0.0)) return FittedLine{};
  line.slope = xy / xx;
  line.offset = y - line.slope * x;
  for (const DissipationCycle& c : cycles) {
    const double off = c.resistance - line.offset - line.slope * c.speed;
    squares += off * off;
  }
  const double variance = squares / line.freedom;
  line.slope_error = std::sqrt(variance / xx);
  line.offset_error = std::sqrt(variance * (1.0 / count + x * x / xx));
  return line;
}

double student(int freedom) {
  // 99.9 % quantile of Student's distribution, from the normal quantile z by the Cornish-Fisher
  // expansion. The expansion gives too small values below four degrees of freedom.
  constexpr double z = 3.0902;
  if (freedom < 4) return 22.3;  // quantile for two degrees of freedom
  const double n = freedom;
  return z + (z * z * z + z) / (4.0 * n) +
         (5.0 * std::pow(z, 5) + 16.0 * z * z * z + 3.0 * z) / (96.0 * n * n) +
         (3.0 * std::pow(z, 7) + 19.0 * std::pow(z, 5) + 17.0 * z * z * z - 15.0 * z) /
             (384.0 * n * n * n);
}

}  // namespace feltwire

#include "client/identify/coast_down.hpp"

#include <array>
#include <cmath>
#include <optional>

#include "client/identify/dissipation_per_cycle.hpp"

namespace feltwire {
namespace {

constexpr std::array kPushes = {0.4, 0.7, 1.0};       // push speed divided by top speed
constexpr std::array kPlaces = {-0.45, -0.4, -0.35};  // start of the coast divided by the amplitude
constexpr double kNoForce = 1e-3;                     // [N] largest force that counts as zero
constexpr double kMargin = 3e-3;  // [s] a force may act for this time after the delay
// Ratio of the slowest evaluated speed to the push speed. Stiction may act at lower speeds.
constexpr double kSlowestCoast = 0.25;
constexpr std::size_t kShortest = 10;  // [ticks] shortest evaluated time
constexpr int kLeastFreedom = 4;

/// Returns the mean position along the coast [m], over the window of velocity_at() around tick k.
double place_at(const CoastDownRecord& run, std::size_t k) {
  double sum = 0.0;
  for (std::size_t n = k - kHalfWindow + 1; n < k + kHalfWindow; ++n)
    sum += run.coast.along.dot(run.ticks[n].position);
  const double ends = run.coast.along.dot(run.ticks[k - kHalfWindow].position +
                                          run.ticks[k + kHalfWindow].position);
  return (sum + 0.5 * ends) / (2.0 * kHalfWindow);
}

double speed_at(const CoastDownRecord& run, std::size_t k) {
  return run.coast.along.dot(velocity_at(run.ticks, k, kHalfWindow));
}

/// Mean deceleration and mean speed of the handle in a coast.
struct Slowing {
  double deceleration, speed;  // [m/s^2], [m/s]
};

/// Returns the mean deceleration in the part of the coast without a force, or nothing if this part
/// is too short. The speed difference of two ticks is the integral of dv/dt = -(b v + f_c) / m,
/// with the damping b, the friction f_c and the mass m. Only the speeds of the two ticks contribute
/// errors.
std::optional<Slowing> slowing(const CoastDownRecord& run, double delay) {
  std::size_t free = run.ticks.size();
  while (free > 0 && std::abs(run.coast.along.dot(run.ticks[free - 1].force)) < kNoForce) --free;
  if (free == run.ticks.size()) return std::nullopt;
  std::size_t first = free;
  while (first < run.ticks.size() && run.ticks[first].time < run.ticks[free].time + delay + kMargin)
    ++first;
  first += kHalfWindow;
  if (first + kShortest + kHalfWindow >= run.ticks.size()) return std::nullopt;
  std::size_t last = run.ticks.size() - kHalfWindow - 1;
  while (last > first && speed_at(run, last) < kSlowestCoast * run.coast.speed) --last;
  if (last < first + kShortest) return std::nullopt;
  const double span = run.ticks[last].time - run.ticks[first].time;
  return Slowing{(speed_at(run, first) - speed_at(run, last)) / span,
                 (place_at(run, last) - place_at(run, first)) / span};
}

}  // namespace

std::vector<CoastDown> coast_down_plan(int dof, double top_speed) {
  std::vector<CoastDown> plan;
  plan.reserve(static_cast<std::size_t>(dof) * 2 * kPushes.size() * kPlaces.size());
  for (int i = 0; i < dof; ++i)
    for (const double from : kPlaces)
      for (const double share : kPushes)
        for (const double sense : {1.0, -1.0})
          plan.push_back({sense * Vec3::Unit(i), share * top_speed, from});
  return plan;
}

DecayFit decay_fit(std::span<const CoastDownRecord> runs, const Vec3& axis, double mass,
                   double delay) {
  std::vector<DissipationCycle> pairs;
  for (std::size_t n = 0; n + 1 < runs.size(); n += 2) {
    if (!runs[n].coast.along.isApprox(axis, 1e-6)) continue;
    const auto there = slowing(runs[n], delay), back = slowing(runs[n + 1], delay);
    if (there && back)
      pairs.push_back({0.5 * mass * (there->deceleration + back->deceleration),
                       0.5 * (there->speed + back->speed), 0.0});
  }
  const FittedLine line = fitted_line(pairs);
  return {line.slope, line.slope_error, line.freedom, line.freedom >= kLeastFreedom};
}

}  // namespace feltwire

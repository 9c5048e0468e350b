#include "client/identify/impulse_fit.hpp"

#include <Eigen/Dense>
#include <cmath>
#include <vector>

#include "client/identify/dissipation_per_cycle.hpp"

namespace feltwire {
namespace {

// [s] Step and end of the delay search.
constexpr double kDelayStep = 0.25e-3, kLongestDelay = 8e-3;
// Ratio of the slowest used speed to the sweep speed. Stiction dominates at lower speeds.
constexpr double kSlowest = 0.2;

/// Mean force, velocity and acceleration along the sweep in a window of ticks. All means use the
/// same window, so noise and delay affect them equally.
struct Means {
  double force, velocity, acceleration;
};

std::vector<Means> means(const SweepRecord& run) {
  constexpr std::size_t h = kHalfWindow;
  std::vector<Means> list;
  if (run.ticks.size() < 6 * h) return list;
  list.reserve(run.ticks.size());
  double sum = 0.0;  // sum of the forces of ticks k-h .. k+h-1
  for (std::size_t k = h; k < 3 * h; ++k) sum += run.sweep.along.dot(run.ticks[k].force);
  for (std::size_t k = 2 * h; k + 2 * h < run.ticks.size(); ++k) {
    const double span = run.ticks[k + h].time - run.ticks[k - h].time;
    const Vec3 before = velocity_at(run.ticks, k - h, h), after = velocity_at(run.ticks, k + h, h);
    list.push_back({sum / (2.0 * h), run.sweep.along.dot(velocity_at(run.ticks, k, h)),
                    run.sweep.along.dot(after - before) / span});
    sum += run.sweep.along.dot(run.ticks[k + h].force - run.ticks[k - h].force);
  }
  return list;
}

struct Fit {
  Eigen::Vector4d x = Eigen::Vector4d::Zero();
  Eigen::Vector4d error = Eigen::Vector4d::Zero();
  double variance = 0.0;
  bool valid = false;
};

/// Fits mass, damping, friction and constant force by least squares. `shift` [ticks]: delay of the
/// movement after the force. `slowest` [m/s]: slowest used speed.
Fit fit(const std::vector<Means>& list, double shift, double slowest) {
  const auto whole = static_cast<std::size_t>(shift);
  const double part = shift - std::floor(shift);
  Eigen::Matrix4d normal = Eigen::Matrix4d::Zero();
  Eigen::Vector4d right = Eigen::Vector4d::Zero();
  double square = 0.0;
  int count = 0;
  for (std::size_t k = 0; k + whole + 1 < list.size(); ++k) {
    const Means &one = list[k + whole], &next = list[k + whole + 1];
    const double v = (1.0 - part) * one.velocity + part * next.velocity;
    if (std::abs(v) < slowest) continue;
    const double a = (1.0 - part) * one.acceleration + part * next.acceleration;
    const Eigen::Vector4d row(a, v, std::copysign(1.0, v), 1.0);
    normal += row * row.transpose();
    right += row * list[k].force;
    square += list[k].force * list[k].force;
    ++count;
  }
  Fit found;
  if (count < 100) return found;
  const Eigen::LDLT<Eigen::Matrix4d> solver(normal);
  found.x = solver.solve(right);
  // The windows of neighbour ticks overlap. So only one of 4 kHalfWindow ticks gives an independent
  // value.
  const double independent = count / (4.0 * kHalfWindow);
  found.variance = std::max(0.0, square - found.x.dot(right)) / count;
  const Eigen::Matrix4d inverse = solver.solve(Eigen::Matrix4d::Identity());
  found.error = (found.variance * count / independent * inverse.diagonal().cwiseAbs()).cwiseSqrt();
  found.valid = found.x.allFinite() && found.error.allFinite();
  return found;
}

}  // namespace

ImpulseFit impulse_fit(const SweepRecord& run) {
  ImpulseFit best;
  const std::vector<Means> list = means(run);
  if (list.empty()) return best;
  const double period =
      (run.ticks.back().time - run.ticks.front().time) / static_cast<double>(run.ticks.size() - 1);
  double least = 0.0;
  const int delays = static_cast<int>(std::lround(kLongestDelay / kDelayStep));
  for (int i = 0; i <= delays; ++i) {
    const double delay = i * kDelayStep;
    const Fit one = fit(list, delay / period, kSlowest * run.sweep.speed);
    if (!one.valid || (best.valid && one.variance >= least)) continue;
    least = one.variance;
    best = {one.x[0], one.error[0], one.x[1], one.error[1], one.x[2], delay, true};
  }
  return best;
}

}  // namespace feltwire

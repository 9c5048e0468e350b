#include "client/identify/lag_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <numbers>
#include <vector>

#include "client/identify/sweep_plan.hpp"

namespace feltwire {
namespace {

using Complex = std::complex<double>;

// Ratio of the settling time after a turn to the time of a stroke.
constexpr double kSettled = 0.05;
constexpr int kRounds = 6;       // iterations of Newton's method
constexpr double kClose = 1e-8;  // [s] change of the lag that ends the iteration
// [s] Largest valid lag L. Above it, the phase of a first-order lag is clearly smaller than w L at
// the frequency w.
constexpr double kMostLag = 4e-3;
constexpr double kMassChange = 0.3;  // relative change of the apparent mass that shows a resonance
constexpr int kLeastFrequencies = 3;
constexpr int kSurplus = 4;  // least number by which the equations exceed the unknowns

/// Test function of a stroke (the movement in one direction, half a cycle), with its derivatives:
/// sin^4, times exp(-j w t) with the time t [s].
class TestFunction {
 public:
  TestFunction(double begins, double ends, double frequency)
      : begins_(begins), ends_(ends), turn_(2.0 * std::numbers::pi * frequency) {}

  double ends() const { return ends_; }
  double turn() const { return turn_; }  // w [rad/s]
  /// Returns the derivative of the order `order`. Order 0 is the function itself.
  Complex derived(int order, double t) const {
    if (!(t > begins_ && t < ends_)) return 0.0;
    // sin^4 is a sum of five exponentials.
    constexpr std::array kShares = {1.0 / 16, -4.0 / 16, 6.0 / 16, -4.0 / 16, 1.0 / 16};
    const double slow = 2.0 * std::numbers::pi / (ends_ - begins_);
    Complex sum = 0.0;
    int n = -2;
    for (const double share : kShares) {
      const double along = slow * n++;
      Complex one = std::polar(share, along * (t - begins_) - turn_ * t);
      for (int k = 0; k < order; ++k) one *= Complex(0.0, along - turn_);
      sum += one;
    }
    return sum;
  }

 private:
  double begins_, ends_, turn_;
};

/// Integrals over one stroke of a shaken sweep, with the position x and the test function p. Each
/// cycle is rotated to a common vibration phase before it is added.
struct ShakenWay {
  const SweepRecord* run;
  TestFunction test;
  Complex accelerated = 0.0;  // integral of x p''
  Complex moved = 0.0;        // integral of -x p'

  /// Returns the integral of f(t - lag) p, with the force f. The device holds a force until the
  /// next tick, and Simpson's rule integrates between the ticks.
  Complex forced(double lag) const;
};

/// Calls visit(rotation, ticks, time) for each cycle. `rotation`: factor that rotates the cycle to
/// the common vibration phase. `ticks`: all ticks from the start of the cycle. `time`: start of the
/// cycle [s].
template <class Visit>
void for_each_cycle(const SweepRecord& run, Visit visit) {
  for (std::size_t n = 0; n + 1 < run.turns.size(); ++n) {
    const std::size_t first = run.turns[n];
    // The sweep begins with an unmeasured cycle.
    const double phase = shake_phase(static_cast<int>(n) + 1);
    visit(std::polar(1.0, -phase), std::span(run.ticks).subspan(first), run.ticks[first].time);
  }
}

Complex ShakenWay::forced(double lag) const {
  Complex sum = 0.0;
  for_each_cycle(*run, [&](const Complex& turned, std::span<const SweepTick> ticks, double origin) {
    for (std::size_t k = 0; k + 1 < ticks.size(); ++k) {
      const double from = ticks[k].time - origin + lag, to = ticks[k + 1].time - origin + lag;
      if (from > test.ends()) break;
      const Complex mean =
          (test.derived(0, from) + 4.0 * test.derived(0, 0.5 * (from + to)) + test.derived(0, to)) /
          6.0;
      sum += turned * (to - from) * run->sweep.along.dot(ticks[k].force) * mean;
    }
  });
  return sum;
}

ShakenWay way_of(const SweepRecord& run, const TestFunction& test) {
  ShakenWay way{&run, test};
  for_each_cycle(run, [&](const Complex& turned, std::span<const SweepTick> ticks, double origin) {
    for (std::size_t k = 1; k + 1 < ticks.size(); ++k) {
      const double at = ticks[k].time - origin;
      if (at > test.ends()) break;
      // The trapezoidal rule suffices, because the function is zero at both ends.
      const double span = 0.5 * (ticks[k + 1].time - ticks[k - 1].time);
      const double x = run.sweep.along.dot(ticks[k].position - ticks[0].position);
      way.accelerated += turned * span * x * test.derived(2, at);
      way.moved -= turned * span * x * test.derived(1, at);
    }
  });
  return way;
}

/// Returns the integrals of both strokes of each run.
std::vector<ShakenWay> ways_of(std::span<const SweepRecord> runs) {
  std::vector<ShakenWay> ways;
  for (const SweepRecord& run : runs) {
    if (run.turns.size() < 5) continue;
    const double cycle = (run.ticks[run.turns.back()].time - run.ticks[run.turns.front()].time) /
                         static_cast<double>(run.turns.size() - 1);
    for (const double begins : {0.0, 0.5}) {
      const double half = 0.5 * cycle, first = begins * cycle + (kTurnShare + kSettled) * half;
      ways.push_back(
          way_of(run, {first, begins * cycle + (1.0 - kTurnShare) * half, run.sweep.shake}));
    }
  }
  return ways;
}

Eigen::Index line_of(std::span<const Vec3> lines, const ShakenWay& way) {
  return std::find(lines.begin(), lines.end(), way.run->sweep.along) - lines.begin();
}

/// Drops the frequencies near a resonance for each shaking direction in `lines`, because the loss
/// model does not hold there. A changed apparent mass shows the resonance. Returns nothing if too
/// few frequencies remain for a direction. Precondition: the frequencies of each direction
/// increase.
std::vector<ShakenWay> below_resonance(std::span<const ShakenWay> ways,
                                       std::span<const Vec3> lines) {
  std::vector<ShakenWay> kept;
  for (const Vec3& line : lines) {
    int count = 0;                                          // number of remaining frequencies
    double first = 0.0;                                     // [kg] mass at the lowest frequency
    for (std::size_t i = 0; i + 1 < ways.size(); i += 2) {  // both strokes of a run
      if (ways[i].run->sweep.along != line) continue;
      const std::span run = ways.subspan(i, 2);
      double mass = 0.0;
      for (const ShakenWay& way : run) mass += 0.5 * (way.forced(0.0) / way.accelerated).real();
      if (count == 0) first = mass;
      if (!(std::abs(mass - first) <= kMassChange * std::abs(first))) break;
      kept.insert(kept.end(), run.begin(), run.end());
      ++count;
    }
    if (count < kLeastFrequencies) return {};
  }
  return kept;
}

/// Least-squares solution with only the columns in `kept`. `x` is zero for the others, and
/// `first_error` is the standard error of the first element of `x`.
struct Solution {
  Eigen::VectorXd x;
  double variance = 0.0, first_error = 0.0;
  int freedom = 0;
};
Solution solve(const Eigen::MatrixXd& rows, const Eigen::VectorXd& right,
               const std::vector<Eigen::Index>& kept) {
  const Eigen::MatrixXd columns = rows(Eigen::all, kept);
  const Eigen::ColPivHouseholderQR<Eigen::MatrixXd> solver(columns);
  Solution found;
  const Eigen::VectorXd x = solver.solve(right);
  found.x = Eigen::VectorXd::Zero(rows.cols());
  for (std::size_t n = 0; n < kept.size(); ++n) found.x[kept[n]] = x[static_cast<Eigen::Index>(n)];
  found.freedom = static_cast<int>(rows.rows() - static_cast<Eigen::Index>(kept.size()));
  found.variance = (right - columns * x).squaredNorm() / std::max(found.freedom, 1);
  const Eigen::MatrixXd inverse = (columns.transpose() * columns).inverse();
  found.first_error = std::sqrt(found.variance * std::abs(inverse(0, 0)));
  return found;
}

}  // namespace

LagFit lag_fit(std::span<const SweepRecord> runs) {
  LagFit fit;
  const std::vector<ShakenWay> shaken = ways_of(runs);
  std::vector<Vec3> lines;
  for (const ShakenWay& way : shaken) {
    if (line_of(lines, way) == static_cast<Eigen::Index>(lines.size()))
      lines.push_back(way.run->sweep.along);
    if (!(std::abs(way.accelerated) > 0.0)) return fit;
  }
  const std::vector<ShakenWay> ways = below_resonance(shaken, lines);
  double top = 0.0;  // [rad/s] highest frequency
  for (const ShakenWay& way : ways) top = std::max(top, way.test.turn());
  // Unknowns: the lag, the damping in each direction, and the additional loss in each direction at
  // the highest frequency.
  const auto count = static_cast<Eigen::Index>(lines.size());
  const auto equations = static_cast<Eigen::Index>(ways.size());
  if (equations < 1 + 2 * count + kSurplus) return fit;
  for (int round = 0; round < kRounds; ++round) {
    Eigen::MatrixXd rows = Eigen::MatrixXd::Zero(equations, 1 + 2 * count);
    Eigen::VectorXd right(equations);
    for (Eigen::Index i = 0; i < equations; ++i) {
      const ShakenWay& way = ways[static_cast<std::size_t>(i)];
      const Complex mass = way.forced(fit.lag) / way.accelerated;
      const double damped = (way.moved / way.accelerated).imag(), length = std::abs(mass);
      if (!(length > 0.0)) return fit;
      rows(i, 0) = way.test.turn() * mass.real() / length;
      rows(i, 1 + line_of(lines, way)) = damped / length;
      rows(i, 1 + count + line_of(lines, way)) =
          damped * std::pow(way.test.turn() / top, 4) / length;
      right[i] = mass.imag() / length;
    }
    std::vector<Eigen::Index> kept;
    for (Eigen::Index n = 0; n < rows.cols(); ++n) kept.push_back(n);
    Solution found = solve(rows, right, kept);
    for (Eigen::Index n = count + 1; n < rows.cols(); ++n)
      if (found.x[n] < 0.0) std::erase(kept, n);
    if (static_cast<Eigen::Index>(kept.size()) < rows.cols()) found = solve(rows, right, kept);
    fit.lag += found.x[0];
    fit.error = found.first_error;
    fit.freedom = found.freedom;
    if (!std::isfinite(fit.lag) || !(std::abs(fit.lag) < kMostLag)) return fit;
    fit.valid = std::abs(found.x[0]) < kClose;
    if (fit.valid) break;
  }
  return fit;
}

}  // namespace feltwire

#include "client/identify/estimate.hpp"

#include <Eigen/Eigenvalues>
#include <algorithm>
#include <cmath>
#include <limits>
#include <sstream>

#include "client/identify/dissipation_per_cycle.hpp"
#include "client/identify/impulse_fit.hpp"
#include "client/identify/lag_fit.hpp"
#include "client/identify/sweep_plan.hpp"
#include "client/identify/transmission_fit.hpp"

namespace feltwire {
namespace {

constexpr double kShare = 0.8;           // ratio of a reported bound to the computed bound
constexpr double kDelayMargin = 0.5e-3;  // [s] largest error of the delay, positive or negative
// [N] Margin of the friction, because noise hides smaller forces.
constexpr double kLeastForce = 2e-3;
constexpr double kSticks = 2.0;  // ratio of the stiction at a turn to the largest resistance
// Relative error of the mean speed, from averaging windows and ripple.
constexpr double kSpeedError = 0.02;
// Relative margin and least margin [s] that are added to the lag.
constexpr double kLagShare = 0.02, kLeastLag = 40e-6;
constexpr double kOpenLag = 0.5e-3;  // [s] largest fit error of a usable lag
constexpr double kHeld = 25.0;       // [N/m] a larger stiffness shows that a hand holds the handle
// Allowed relative difference of two damping estimates, in addition to the fit errors.
constexpr double kDisagreement = 0.3;

/// Value u' A u of a damping or mass matrix A in the direction u. The true value may be smaller by
/// `uncertainty`.
struct AlongLine {
  Vec3 along = Vec3::Zero();
  double value = 0.0, uncertainty = 0.0;
};

const AlongLine* find_line(std::span<const AlongLine> lines, const Vec3& along) {
  const auto found = std::find_if(lines.begin(), lines.end(), [&](const AlongLine& line) {
    return line.along.isApprox(along, 1e-6);
  });
  return found == lines.end() ? nullptr : &*found;
}

/// Symmetric matrix, and the largest error of each element.
struct Measured {
  Mat3 value = Mat3::Zero(), uncertainty = Mat3::Zero();
};

/// Computes the matrix from its values along the axes and along the diagonals of each pair of axes.
/// Precondition: `lines` contains all directions of sweep_plan().
Measured measured(std::span<const AlongLine> lines, int dof) {
  Measured found;
  for (int i = 0; i < dof; ++i) {
    const AlongLine* axis = find_line(lines, Vec3::Unit(i));
    found.value(i, i) = axis->value;
    found.uncertainty(i, i) = axis->uncertainty;
    for (int j = i + 1; j < dof; ++j) {
      const AlongLine* plus = find_line(lines, (Vec3::Unit(i) + Vec3::Unit(j)).normalized());
      const AlongLine* minus = find_line(lines, (Vec3::Unit(i) - Vec3::Unit(j)).normalized());
      found.value(i, j) = found.value(j, i) = 0.5 * (plus->value - minus->value);
      found.uncertainty(i, j) = found.uncertainty(j, i) =
          0.5 * std::hypot(plus->uncertainty, minus->uncertainty);
    }
  }
  return found;
}

/// Returns the diagonal of a matrix D below A: A - D is diagonally dominant (Gershgorin). If the
/// axes are strongly coupled, each element is instead the smallest eigenvalue of A.
Vec3 diagonal_below(const Measured& a, int dof) {
  Vec3 below = Vec3::Zero();
  for (int i = 0; i < dof; ++i) {
    below[i] = a.value(i, i) - a.uncertainty(i, i);
    for (int j = 0; j < dof; ++j)
      if (j != i) below[i] -= std::abs(a.value(i, j)) + a.uncertainty(i, j);
  }
  const Eigen::SelfAdjointEigenSolver<Eigen::MatrixXd> values(a.value.topLeftCorner(dof, dof),
                                                              Eigen::EigenvaluesOnly);
  const double least = std::max(0.0, values.eigenvalues()[0] - a.uncertainty.norm());
  if (below.head(dof).minCoeff() >= least) return below;
  Vec3 same = Vec3::Zero();
  same.head(dof).setConstant(least);
  return same;
}

/// All sweeps in one direction. They are adjacent in the plan.
struct Line {
  Vec3 along = Vec3::Zero();
  std::vector<const SweepRecord*> runs;
  ImpulseFit impulse;  // fit of the fastest sweep
};

std::vector<Line> lines_of(std::span<const SweepRecord> runs) {
  std::vector<Line> lines;
  for (const SweepRecord& run : runs) {
    if (lines.empty() || !lines.back().along.isApprox(run.sweep.along, 1e-6))
      lines.push_back({run.sweep.along, {}, {}});
    lines.back().runs.push_back(&run);
  }
  for (Line& line : lines) {
    const auto slower = [](const SweepRecord* a, const SweepRecord* b) {
      return a->sweep.speed < b->sweep.speed;
    };
    line.impulse = impulse_fit(**std::max_element(line.runs.begin(), line.runs.end(), slower));
  }
  return lines;
}

/// Returns a lower bound of the friction in one direction [N], from the smaller of two fits. The
/// first fit uses all cycles. The second fit uses only the fast cycles, where stiction has no
/// effect.
double friction_below(const std::vector<DissipationCycle>& cycles) {
  const FittedLine all = fitted_line(cycles);
  double fastest = 0.0, most = 0.0, slow_share = 0.0;
  for (const DissipationCycle& c : cycles) {
    fastest = std::max(fastest, c.speed);
    most = std::max(most, c.resistance);
  }
  std::vector<DissipationCycle> faster;
  for (const DissipationCycle& c : cycles)
    if (c.speed > 0.4 * fastest) {
      faster.push_back(c);
      slow_share = std::max(slow_share, c.slow_share);
    }
  const FittedLine half = fitted_line(faster);
  const double from_all = all.offset - student(all.freedom) * all.offset_error;
  const double from_half = half.offset - student(half.freedom) * half.offset_error;
  return std::min(from_all, from_half) - kLeastForce - kSticks * slow_share * most -
         kSpeedError * std::max(0.0, all.slope) * 0.5 * fastest;
}

std::vector<DissipationCycle> cycles_of(const Line& line, double delay) {
  std::vector<DissipationCycle> cycles;
  for (const SweepRecord* run : line.runs)
    for (const DissipationCycle& cycle : dissipation_per_cycle(*run, delay, line.impulse.mass))
      cycles.push_back(cycle);
  return cycles;
}

std::string line_name(const Vec3& along) {
  std::string text;
  for (int i = 0; i < 3; ++i)
    if (std::abs(along[i]) > 1e-6)
      text.append(along[i] < 0.0 ? "-" : text.empty() ? "" : "+").push_back("xyz"[i]);
  return text;
}

/// Returns a warning if the other method finds clearly less damping than the energy method, else an
/// empty text. More damping needs no warning: stiction or friction per axis can cause it, and the
/// smaller value is safe. `open`: combined uncertainty of both methods [N s/m].
std::string disagreement(const Vec3& along, const FittedLine& energy, const char* other,
                         double damping, double open) {
  if (energy.slope - damping <= kDisagreement * std::abs(energy.slope) + open) return {};
  std::ostringstream text;
  text << "along " << line_name(along) << " the energy says a damping of " << energy.slope
       << " N s/m and the " << other << " only " << damping
       << ": does somebody hold the handle, or is the maker's own damping on?";
  return text.str();
}

/// Compares the damping with the damping from the decay of a coast along an axis. Adds a doubt if
/// they disagree. The decay can only lower the resulting damping.
void cross_check(std::span<const CoastDownRecord> coasts, std::size_t axis, const Line& line,
                 const FittedLine& energy, const AlongLine& damping, DeviceEstimate& found) {
  const ImpulseFit& impulse = line.impulse;
  const DecayFit decay = decay_fit(coasts, line.along, impulse.mass, impulse.delay);
  if (!decay.valid) return;
  const double of_mass = decay.damping * impulse.mass_error / impulse.mass;
  const double error = student(decay.freedom) * std::hypot(decay.damping_error, of_mass);
  found.decay[axis] = decay.damping;
  found.decay_limit[static_cast<Eigen::Index>(axis)] = std::max(0.0, decay.damping + error);
  std::string doubt = disagreement(line.along, energy, "decay", decay.damping,
                                   std::hypot(error, damping.uncertainty));
  if (!doubt.empty()) found.doubts.push_back(std::move(doubt));
}

void read_noise(std::span<const SweepRecord> runs, std::span<const SweepTick> rest,
                DeviceEstimate& found) {
  double least = std::numeric_limits<double>::infinity();
  for (const SweepRecord& run : runs)
    for (std::size_t k = 1; k < run.ticks.size(); ++k)
      for (const double step : (run.ticks[k].position - run.ticks[k - 1].position).cwiseAbs())
        if (step > 1e-12) least = std::min(least, step);
  found.quantum = std::isfinite(least) ? least : 0.0;
  if (rest.size() < 2) return;
  found.tick = (rest.back().time - rest.front().time) / static_cast<double>(rest.size() - 1);
  Vec3 mean = Vec3::Zero(), squares = Vec3::Zero();
  const double count = static_cast<double>(rest.size());
  for (const SweepTick& tick : rest) mean += tick.position / count;
  for (const SweepTick& tick : rest) squares += (tick.position - mean).cwiseAbs2() / count;
  found.noise = std::sqrt(squares.maxCoeff());
}

void read_lag(std::span<const SweepRecord> shaken, DeviceEstimate& found) {
  const LagFit fit = lag_fit(shaken);
  if (!fit.valid) return;
  const double open = student(fit.freedom) * fit.error;
  // Refuse a negative lag, because a motor cannot act before its command.
  if (!(open < kOpenLag && fit.lag + open + kLeastLag > 0.0)) return;
  found.lag = fit.lag;
  found.lag_bound = std::max(0.0, fit.lag + open) * (1.0 + kLagShare) + kLeastLag;
}

/// Reads the transmission of each axis. The softest one counts, and there is none if an axis does
/// not tell its own, or if the axes tell different sides of the encoder.
void read_transmission(std::span<const SweepRecord> shaken, int dof, DeviceEstimate& found) {
  std::optional<TransmissionFit> softest;
  for (int axis = 0; axis < dof; ++axis) {
    std::vector<SweepRecord> along;
    for (const SweepRecord& run : shaken)
      if (run.sweep.along == Vec3::Unit(axis)) along.push_back(run);
    TransmissionFit fit = transmission_fit(along);
    if (!fit.valid || (softest && softest->side != fit.side)) return;
    fit.stiffness_bound *= kShare;
    if (!softest || fit.stiffness_bound < softest->stiffness_bound) softest = fit;
  }
  found.transmission = softest;
}

}  // namespace

DeviceEstimate estimate(std::span<const SweepRecord> all_runs,
                        std::span<const CoastDownRecord> coasts, std::span<const SweepTick> rest,
                        int dof) {
  DeviceEstimate found;
  const auto shaken = std::find_if(all_runs.begin(), all_runs.end(),
                                   [](const SweepRecord& run) { return run.sweep.shake > 0.0; });
  const std::span runs(all_runs.begin(), shaken);
  read_noise(runs, rest, found);
  const auto resonance = std::find_if(shaken, all_runs.end(), [](const SweepRecord& run) {
    return run.sweep.shake > kHighestLagShake;
  });
  read_lag({shaken, resonance}, found);
  read_transmission({shaken, all_runs.end()}, dof, found);
  const std::vector<Line> lines = lines_of(runs);
  double least_delay = std::numeric_limits<double>::infinity(), most_delay = 0.0;
  for (const Line& line : lines) {
    if (!line.impulse.valid) {
      found.doubts.push_back("along " + line_name(line.along) +
                             " the handle hardly moved; allow more force (--force)");
      return found;
    }
    least_delay = std::min(least_delay, line.impulse.delay);
    most_delay = std::max(most_delay, line.impulse.delay);
  }
  const double made_good = std::max(0.0, least_delay - kDelayMargin);

  std::vector<AlongLine> dampings, masses;
  found.friction = found.friction_bound = std::numeric_limits<double>::infinity();
  for (const Line& line : lines) {
    const ImpulseFit& impulse = line.impulse;
    const std::vector<DissipationCycle> cycles = cycles_of(line, made_good);
    const FittedLine energy = fitted_line(cycles);
    const double t = student(energy.freedom);
    dampings.push_back({line.along, energy.slope, t * energy.slope_error});
    masses.push_back({line.along, impulse.mass, student(30) * impulse.mass_error});
    found.friction = std::min(found.friction, energy.offset);
    // Estimate the friction with a small and with a large delay compensation, and take the smaller
    // value. Too small a compensation raises the friction, and too large a compensation lowers it.
    found.friction_bound = std::min({found.friction_bound, friction_below(cycles),
                                     friction_below(cycles_of(line, most_delay + kDelayMargin))});
    if (pull_back(*line.runs.front()) > kHeld)
      found.doubts.push_back("along " + line_name(line.along) +
                             " the handle pulls back to a place: does somebody hold it?");
    if (std::string doubt = disagreement(line.along, energy, "impulse", impulse.damping,
                                         t * std::hypot(energy.slope_error, impulse.damping_error));
        !doubt.empty())
      found.doubts.push_back(std::move(doubt));
    for (std::size_t axis = 0; axis < 3; ++axis)
      if (line.along[static_cast<Eigen::Index>(axis)] == 1.0)
        cross_check(coasts, axis, line, energy, dampings.back(), found);
  }
  Measured damping = measured(dampings, dof);
  const Measured mass = measured(masses, dof);
  found.damping = damping.value.diagonal();
  for (int i = 0; i < dof; ++i)
    damping.value(i, i) = std::min(damping.value(i, i), found.decay_limit[i]);
  found.mass = mass.value.diagonal();
  found.damping_bound = kShare * diagonal_below(damping, dof);
  found.mass_bound = kShare * diagonal_below(mass, dof).head(dof).minCoeff();
  found.friction_bound = std::max(0.0, kShare * found.friction_bound);
  return found;
}

}  // namespace feltwire

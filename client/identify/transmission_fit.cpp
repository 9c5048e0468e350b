#include "client/identify/transmission_fit.hpp"

#include <Eigen/Dense>
#include <algorithm>
#include <array>
#include <cmath>
#include <complex>
#include <limits>
#include <numbers>
#include <vector>

#include "client/identify/dissipation_per_cycle.hpp"
#include "client/identify/sweep_plan.hpp"

namespace feltwire {
namespace {

using Phasor = std::complex<double>;

constexpr double kAfterTurn = 0.05;   // ratio of the settling time after a turn to a stroke's time
constexpr double kOfNyquist = 0.8;    // ratio of the highest used frequency to half the tick rate
constexpr int kImages = 4;            // images of the held force, above and below
constexpr double kModelError = 0.01;  // relative error of each answer, beside the noise
constexpr double kMostOpen = 0.5;     // largest relative error of a usable stiffness
// The least ratio of the misfits of both sides, and the most that the better one is beyond noise.
constexpr double kClearly = 2.0, kFits = 100.0;
constexpr int kLeastAnswers = 12;
// [Hz] Frequencies beside the shake, outside of the window's width. They are above it, because the
// movement itself is slow.
constexpr std::array kBeside = {13.0, 17.0, 22.0, 28.0};
constexpr int kSteps = 60;  // of the least squares

/// The answer of the handle to the shake, over the strokes in one direction of a run.
struct Answer {
  double turn = 0.0;       // [rad/s]
  double period = 0.0;     // [s] mean time between two ticks
  Phasor ratio{};          // position over force [m/N]
  double uncertain = 1.0;  // relative standard error
};

/// Correlates the strokes from `begins` to `ends` [s] of each cycle with the shake, and with
/// frequencies beside it, which show what else moves the readings.
Answer answer_of(const SweepRecord& run, double begins, double ends) {
  Answer answer{.turn = 2.0 * std::numbers::pi * run.sweep.shake};
  Phasor moved{}, forced{};
  std::array<Phasor, kBeside.size()> beside{};
  double span = 0.0, count = 0.0;
  for (std::size_t n = 0; n + 1 < run.turns.size(); ++n) {
    const std::size_t first = run.turns[n];
    const double origin = run.ticks[first].time, phase = shake_phase(static_cast<int>(n) + 1);
    for (std::size_t k = first; k + 1 < run.ticks.size(); ++k) {
      const double t = run.ticks[k].time - origin;
      if (t >= ends) break;
      if (t <= begins) continue;
      const double wave = std::sin(std::numbers::pi * (t - begins) / (ends - begins));
      const double weight = wave * wave * wave * wave;
      const Phasor turned = std::polar(weight, -answer.turn * t - phase);
      const double place = run.sweep.along.dot(run.ticks[k].position - run.ticks[first].position);
      moved += turned * place;
      forced += turned * run.sweep.along.dot(run.ticks[k].force);
      for (std::size_t i = 0; i < beside.size(); ++i)
        beside[i] += std::polar(1.0, -2.0 * std::numbers::pi * kBeside[i] * t) * turned * place;
      span += run.ticks[k + 1].time - run.ticks[k].time;
      count += 1.0;
    }
  }
  if (!(count > 0.0) || !(std::abs(forced) > 0.0) || !(std::abs(moved) > 0.0)) return answer;
  answer.period = span / count;
  answer.ratio = moved / forced;
  double squared = 0.0;
  for (const Phasor& other : beside)
    squared += std::norm(other) / static_cast<double>(beside.size());
  answer.uncertain = std::hypot(kModelError, std::sqrt(0.5 * squared) / std::abs(moved));
  return answer;
}

std::vector<Answer> answers_of(std::span<const SweepRecord> runs) {
  std::vector<Answer> answers;
  for (const SweepRecord& run : runs) {
    if (run.turns.size() < 5) continue;
    const double cycle = (run.ticks[run.turns.back()].time - run.ticks[run.turns.front()].time) /
                         static_cast<double>(run.turns.size() - 1);
    for (const double stroke : {0.0, 0.5}) {
      const double half = 0.5 * cycle, from = stroke * cycle;
      const Answer answer =
          answer_of(run, from + (kTurnShare + kAfterTurn) * half, from + (1.0 - kTurnShare) * half);
      const double highest = kOfNyquist * std::numbers::pi / answer.period;
      if (answer.period > 0.0 && answer.turn < highest && answer.uncertain < 0.5)
        answers.push_back(answer);
    }
  }
  return answers;
}

/// The numbers of a device along one axis.
struct Unknown {
  enum { mass, share, stiffness, loss, delay, filter, drag, count };
};
using Numbers = Eigen::Matrix<double, Unknown::count, 1>;

/// Returns the device's position over the force, with the numbers as the fit has them: logarithms
/// of mass, stiffness and loss, the logit of the handle's share, and the roots of the others.
struct Model {
  double mass, handle, stiffness, damping, delay, filter, drag;
  explicit Model(const Numbers& u)
      : mass(std::exp(u[Unknown::mass])),
        handle(mass / (1.0 + std::exp(-u[Unknown::share]))),
        stiffness(std::exp(u[Unknown::stiffness])),
        damping(std::exp(u[Unknown::loss]) * std::sqrt(stiffness * reduced())),
        delay(u[Unknown::delay] * u[Unknown::delay]),
        filter(u[Unknown::filter] * u[Unknown::filter]),
        drag(u[Unknown::drag] * u[Unknown::drag]) {}
  double reduced() const { return handle * (mass - handle) / mass; }

  Phasor continuous(Phasor s, EncoderSide side) const {
    const Phasor link = stiffness + damping * s, behind = handle * s * s + link;
    const Phasor of_motor =
        1.0 / ((mass - handle) * s * s + drag * s + handle * s * s * link / behind);
    const Phasor place = side == EncoderSide::motor ? of_motor : of_motor * link / behind;
    return place * std::exp(-s * delay) / (1.0 + filter * s);
  }
  /// A force that is held between ticks has images of each frequency about the tick rate.
  Phasor sampled(const Answer& at, EncoderSide side) const {
    Phasor sum{};
    for (int image = -kImages; image <= kImages; ++image) {
      const Phasor s(0.0, at.turn + 2.0 * std::numbers::pi * image / at.period);
      sum += continuous(s, side) * (1.0 - std::exp(-s * at.period)) / (s * at.period);
    }
    return sum;
  }
};

Eigen::VectorXd misfit(const std::vector<Answer>& answers, const Numbers& u, EncoderSide side) {
  const Model model(u);
  Eigen::VectorXd left(2 * static_cast<Eigen::Index>(answers.size()));
  Eigen::Index row = 0;
  for (const Answer& answer : answers) {
    const Phasor off = (model.sampled(answer, side) / answer.ratio - 1.0) / answer.uncertain;
    left[row++] = off.real();
    left[row++] = off.imag();
  }
  return left;
}

struct Fitted {
  Numbers u = Numbers::Zero();
  double misfit = std::numeric_limits<double>::infinity();  // sum of squares
  Eigen::MatrixXd slopes{};
};

/// The unknowns that are fitted: at the handle the share of the mass makes no difference.
std::vector<int> free_unknowns(EncoderSide side) {
  std::vector<int> free;
  for (int n = 0; n < Unknown::count; ++n)
    if (n != Unknown::share || side == EncoderSide::motor) free.push_back(n);
  return free;
}

/// Least squares from a first guess on (Levenberg and Marquardt).
Fitted fitted_from(const std::vector<Answer>& answers, const Numbers& guess, EncoderSide side) {
  constexpr double kStep = 1e-6, kMostChange = 1.0;
  const std::vector<int> free = free_unknowns(side);
  const auto columns = static_cast<Eigen::Index>(free.size());
  Fitted found{.u = guess};
  Eigen::VectorXd left = misfit(answers, guess, side);
  found.misfit = left.squaredNorm();
  double damped = 1e-2;
  for (int step = 0; step < kSteps; ++step) {
    found.slopes.resize(left.size(), columns);
    for (Eigen::Index c = 0; c < columns; ++c) {
      Numbers beside = found.u;
      beside[free[static_cast<std::size_t>(c)]] += kStep;
      found.slopes.col(c) = (misfit(answers, beside, side) - left) / kStep;
    }
    Eigen::MatrixXd normal = found.slopes.transpose() * found.slopes;
    const Eigen::VectorXd down = -found.slopes.transpose() * left;
    bool better = false;
    for (int trial = 0; trial < 8 && !better; ++trial, damped *= 4.0) {
      Eigen::MatrixXd raised = normal;
      raised.diagonal() += damped * normal.diagonal() + Eigen::VectorXd::Constant(columns, 1e-9);
      Eigen::VectorXd change = raised.ldlt().solve(down);
      if (!change.allFinite()) continue;
      change = change.cwiseMax(-kMostChange).cwiseMin(kMostChange);
      Numbers next = found.u;
      for (Eigen::Index c = 0; c < columns; ++c)
        next[free[static_cast<std::size_t>(c)]] += change[c];
      const Eigen::VectorXd then = misfit(answers, next, side);
      if (!(then.squaredNorm() < found.misfit)) continue;
      const bool done = found.misfit - then.squaredNorm() < 1e-9 * found.misfit;
      found.u = next;
      left = then;
      found.misfit = then.squaredNorm();
      damped *= 0.05;
      better = !done;
      break;
    }
    if (!better) break;
  }
  return found;
}

/// Returns the best fit of several first guesses.
Fitted best_fit(const std::vector<Answer>& answers, EncoderSide side) {
  constexpr std::array kFirstGuesses = {25.0,  40.0,  60.0,  90.0,
                                        140.0, 220.0, 350.0, 550.0};  // [Hz]
  const Answer& slow = answers.front();
  // At the lowest frequency the whole device moves as one mass.
  const double mass = std::max(1e-4, -(1.0 / (slow.ratio * slow.turn * slow.turn)).real());
  Fitted best;
  for (const double resonance : kFirstGuesses)
    for (const double share : {0.15, 0.4}) {
      const double turn = 2.0 * std::numbers::pi * resonance;
      const double at = side == EncoderSide::motor ? share : 0.5;
      Numbers guess;
      guess[Unknown::mass] = std::log(mass);
      guess[Unknown::share] = std::log(at / (1.0 - at));
      guess[Unknown::stiffness] = std::log(turn * turn * mass * at * (1.0 - at));
      guess[Unknown::loss] = std::log(0.1);
      guess[Unknown::delay] = guess[Unknown::filter] = 1e-2;
      guess[Unknown::drag] = 0.3;
      const Fitted found = fitted_from(answers, guess, side);
      if (found.misfit < best.misfit) best = found;
      if (side == EncoderSide::handle) break;
    }
  return best;
}

/// Returns the relative standard error of the stiffness. It counts misfits beyond the noise.
double stiffness_error(const Fitted& fit, EncoderSide side, int freedom) {
  const std::vector<int> free = free_unknowns(side);
  const auto column = std::find(free.begin(), free.end(), Unknown::stiffness) - free.begin();
  Eigen::MatrixXd normal = fit.slopes.transpose() * fit.slopes;
  normal.diagonal().array() += 1e-9;
  const double variance = std::max(1.0, fit.misfit / std::max(1, freedom));
  const double squared = normal.inverse()(column, column) * variance;
  return squared > 0.0 ? std::sqrt(squared) : std::numeric_limits<double>::infinity();
}

}  // namespace

TransmissionFit transmission_fit(std::span<const SweepRecord> runs) {
  TransmissionFit found;
  const std::vector<Answer> answers = answers_of(runs);
  if (static_cast<int>(answers.size()) < kLeastAnswers) return found;
  const Fitted motor = best_fit(answers, EncoderSide::motor);
  const Fitted handle = best_fit(answers, EncoderSide::handle);
  const bool at_motor = motor.misfit <= handle.misfit;
  const Fitted &best = at_motor ? motor : handle, &other = at_motor ? handle : motor;
  found.side = at_motor ? EncoderSide::motor : EncoderSide::handle;
  const int freedom =
      2 * static_cast<int>(answers.size()) - static_cast<int>(free_unknowns(found.side).size());
  const Model model(best.u);
  found.stiffness = model.stiffness;
  found.resonance = std::sqrt(model.stiffness / model.reduced()) / (2.0 * std::numbers::pi);
  found.handle_mass = at_motor ? model.handle : 0.0;
  const double open = student(freedom) * stiffness_error(best, found.side, freedom);
  found.stiffness_bound = model.stiffness * std::exp(-open);
  if (!at_motor)  // the fit has half of the mass on either side
    found.stiffness_bound *= 4.0 * kLeastMassShare * (1.0 - kLeastMassShare);
  found.valid =
      open < kMostOpen && other.misfit > kClearly * best.misfit && best.misfit < kFits * freedom;
  return found;
}

}  // namespace feltwire

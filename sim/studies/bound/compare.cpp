#include "sim/studies/bound/compare.hpp"

#include <algorithm>
#include <cmath>
#include <stdexcept>

#include "core/base/parallel.hpp"
#include "sim/measure/experiment_metrics.hpp"

namespace feltwire {
namespace {

constexpr double kReferenceRate = 20000.0;  // [Hz] servo rate of the reference

ExperimentSetup task_setup(const CompareTask& task, const CompareLoop& loop) {
  ExperimentSetup setup;
  setup.hand.spec = builtin_device("simulated");
  setup.hand.spec.damping = loop.damping;
  setup.hand.hand = loop.hand;
  setup.hand.task = task.hand;
  setup.duration = task.duration;
  setup.bounding.mode = kUnbounded;
  setup.bounding.period = 1.0 / loop.rate;
  setup.bounding.damping = loop.damping;
  setup.delay = delay_samples(loop.delay, setup.bounding.period);
  return setup;
}

/// Returns the ratio of displayed to commanded stiffness: sum(r.e) / sum(e.e), with the rendered
/// force r and the elastic force e of the surface at the same position.
double displayed_share(const std::vector<ExperimentSample>& samples,
                       const Environment& environment) {
  const Environment own = environment;  // a copy with its own, initial state
  double rendered = 0.0, whole = 0.0;
  for (const ExperimentSample& s : samples) {
    const Vec3 e = own(Tool{s.position, Vec3::Zero()}).elastic;
    rendered += s.rendered.force().dot(e);
    whole += e.squaredNorm();
  }
  return whole > 0.0 ? rendered / whole : 0.0;
}

void check(const CompareLoop& loop) {
  if (!(loop.rate > 0.0) || !std::isfinite(loop.rate))
    throw std::invalid_argument("the servo rate must be finite and above zero [Hz]");
  if (!(loop.delay >= 0.0) || loop.delay > 1.0)
    throw std::invalid_argument("the round trip must be between 0 and 1 s");
}

/// The samples and the setup of a run, from which step_cost() repeats the run.
struct Run {
  std::vector<ExperimentSample> samples;
  ExperimentSetup setup;
};

/// Runs a task and returns its row, without the cost. Stores the samples and the setup in `run`.
CompareRow run_task(const CompareTask& task, const std::string& label, const ExperimentSetup& setup,
                    Run& run) {
  const double period = setup.bounding.period;
  run = {run_experiment(task.touch, setup), setup};
  const auto& samples = run.samples;
  const ExperimentMetrics metrics = measure(samples, {}, setup.bounding.damping, period);
  std::vector<double> distance;
  distance.reserve(samples.size());
  for (const ExperimentSample& s : samples) distance.push_back(task.distance(s.position));
  return {.task = task.name,
          .method = label,
          .oscillation = highpass_rms(distance, 1.0 / period),
          .direction_error = metrics.direction_error.mean,
          .displayed = displayed_share(samples, task.touch),
          // max() also turns -0 into 0.
          .energy_made = std::max(0.0, -metrics.min_port_margin)};
}

}  // namespace

std::vector<CompareRow> compare(const std::vector<CompareTask>& tasks,
                                const std::vector<Method>& methods, const CompareLoop& loop,
                                const StepCost& step_cost) {
  check(loop);
  const std::size_t per_task = methods.size() + 1;
  std::vector<CompareRow> rows(tasks.size() * per_task);
  std::vector<Run> runs(rows.size());
  parallel_for(rows.size(), [&](std::size_t i) {
    const CompareTask& task = tasks[i / per_task];
    if (i % per_task == 0) {
      ExperimentSetup setup = task_setup(task, {loop.damping, kReferenceRate, 0.0, loop.hand});
      setup.hand.spec.position_resolution = 0.0;
      rows[i] = run_task(task, kReference, setup, runs[i]);
      return;
    }
    const Method& method = methods[i % per_task - 1];
    ExperimentSetup setup = task_setup(task, loop);
    method.apply(setup.bounding);
    rows[i] = run_task(task, std::string(method.label), setup, runs[i]);
  });
  for (std::size_t i = 0; i < rows.size(); ++i) {
    rows[i].cost = step_cost(runs[i].samples, runs[i].setup);
    runs[i] = {};
  }
  return rows;
}

std::vector<CompareHandsRow> compare_hands(const std::vector<CompareTask>& tasks,
                                           const std::vector<Method>& methods,
                                           const CompareLoop& loop) {
  check(loop);
  constexpr std::size_t kHands = kEightHands.size();
  std::vector<CompareRow> runs(tasks.size() * methods.size() * kHands);
  parallel_for(runs.size(), [&](std::size_t i) {
    const CompareTask& task = tasks[i / kHands / methods.size()];
    const Method& method = methods[i / kHands % methods.size()];
    CompareLoop with = loop;
    with.hand = kEightHands[i % kHands].hand;
    ExperimentSetup setup = task_setup(task, with);
    method.apply(setup.bounding);
    Run run;
    runs[i] = run_task(task, std::string(method.label), setup, run);
  });
  std::vector<CompareHandsRow> rows;
  for (std::size_t i = 0; i < runs.size(); i += kHands) {
    CompareHandsRow row{.task = runs[i].task, .method = runs[i].method};
    std::vector<double> oscillations, displayed;
    for (std::size_t hand = 0; hand < kHands; ++hand) {
      const CompareRow& run = runs[i + hand];
      oscillations.push_back(run.oscillation);
      displayed.push_back(run.displayed);
      row.energy_made = std::max(row.energy_made, run.energy_made);
    }
    row.oscillation = median(oscillations);
    row.worst_oscillation = std::ranges::max(oscillations);
    row.displayed = median(displayed);
    row.least_displayed = std::ranges::min(displayed);
    rows.push_back(row);
  }
  return rows;
}

}  // namespace feltwire

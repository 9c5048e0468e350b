#include "sim/compare.hpp"

#include <algorithm>
#include <chrono>
#include <cmath>
#include <limits>
#include <stdexcept>

#include "core/parallel.hpp"
#include "sim/metrics.hpp"

namespace feltwire {
namespace {

constexpr double kHighpass = 51e-3;         // [s]
constexpr double kReferenceRate = 20000.0;  // [Hz]

ExperimentSetup task_setup(const CompareTask& task, const CompareLoop& loop) {
  ExperimentSetup setup;
  setup.hand.spec = builtin_device("simulated");
  setup.hand.spec.damping = loop.damping;
  setup.hand.task = task.hand;
  setup.duration = task.duration;
  setup.bounding.mode = BoundingMode::none;
  setup.bounding.period = 1.0 / loop.rate;
  setup.bounding.damping = loop.damping;
  setup.delay = delay_samples(loop.delay, setup.bounding.period);
  return setup;
}

/// Sum r.e / sum e.e of rendered forces r and the surface's own, e.
double displayed_share(const std::vector<ExperimentSample>& samples,
                       const Environment& environment) {
  const Environment own = environment;  // in a fresh state
  double rendered = 0.0, whole = 0.0;
  for (const ExperimentSample& s : samples) {
    const Vec3 e = own(Tool{s.position, Vec3::Zero()}).elastic;
    rendered += s.rendered.force().dot(e);
    whole += e.squaredNorm();
  }
  return whole > 0.0 ? rendered / whole : 0.0;
}

/// The quickest of some replays, so that what else the machine does counts little.
double step_cost(const std::vector<ExperimentSample>& samples, const BoundingConfig& config) {
  using Clock = std::chrono::steady_clock;
  double best = std::numeric_limits<double>::infinity();
  for (int replay = 0; replay < 5; ++replay) {
    Bounding bounding(config);
    double sum = 0.0;
    const auto begin = Clock::now();
    for (const ExperimentSample& s : samples) {
      sum += bounding
                 .step({.displacement = s.displacement,
                        .rotation = Vec3::Zero(),
                        .hold_time = config.period,
                        .command = s.commanded})
                 .rendered.elastic.x();
      bounding.set_held(s.rendered);
    }
    const std::chrono::duration<double, std::nano> time = Clock::now() - begin;
    // The sum is used, or the compiler might leave the steps out.
    if (std::isfinite(sum)) best = std::min(best, time.count());
  }
  return best / static_cast<double>(samples.size());
}

CompareRow run_task(const CompareTask& task, const std::string& label,
                    const ExperimentSetup& setup) {
  const double period = setup.bounding.period;
  const auto samples = run_experiment(task.touch, setup);
  const ExperimentMetrics metrics = measure(samples, {}, setup.bounding.damping, period);
  std::vector<double> distance;
  distance.reserve(samples.size());
  for (const ExperimentSample& s : samples) distance.push_back(task.distance(s.position));
  const int window = 2 * static_cast<int>(kHighpass / 2.0 / period) + 1;
  return {.task = task.name,
          .method = label,
          .oscillation = highpass_rms(distance, window),
          .direction_error = metrics.direction_error.mean,
          .displayed = displayed_share(samples, task.touch),
          // Not -0.
          .energy_made = std::max(0.0, -metrics.min_port_margin),
          .cost = step_cost(samples, setup.bounding)};
}

}  // namespace

std::vector<CompareRow> compare(const std::vector<CompareTask>& tasks,
                                const std::vector<Method>& methods, const CompareLoop& loop) {
  if (!(loop.rate > 0.0) || !std::isfinite(loop.rate))
    throw std::invalid_argument("the servo rate must be finite and above zero [Hz]");
  if (!(loop.delay >= 0.0) || loop.delay > 1.0)
    throw std::invalid_argument("the round trip must be between 0 and 1 s");
  const std::size_t per_task = methods.size() + 1;
  std::vector<CompareRow> rows(tasks.size() * per_task);
  parallel_for(rows.size(), [&](std::size_t i) {
    const CompareTask& task = tasks[i / per_task];
    if (i % per_task == 0) {
      ExperimentSetup setup = task_setup(task, {loop.damping, kReferenceRate, 0.0});
      setup.hand.spec.position_resolution = 0.0;
      rows[i] = run_task(task, kReference, setup);
      return;
    }
    const Method& method = methods[i % per_task - 1];
    ExperimentSetup setup = task_setup(task, loop);
    method.configure(setup.bounding);
    rows[i] = run_task(task, std::string(method.label), setup);
  });
  return rows;
}

}  // namespace feltwire
